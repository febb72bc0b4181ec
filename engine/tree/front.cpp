#include "engine/tree/front.hpp"

#include <algorithm>
#include <iterator>

#include "engine/base/error.hpp"

namespace tetfront {

namespace {

template <class T>
void sort_unique(std::vector<T>& v) {
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
}

/// sorted := (sorted without those for which !keep) merged with `added` (sorted, disjoint).
template <class T, class Keep>
void update_sorted(std::vector<T>& sorted, const std::vector<T>& added, const Keep& keep) {
    std::erase_if(sorted, [&](T v) { return !keep(v); });
    const auto middle = static_cast<std::ptrdiff_t>(sorted.size());
    sorted.insert(sorted.end(), added.begin(), added.end());
    std::inplace_merge(sorted.begin(), sorted.begin() + middle, sorted.end());
}

}  // namespace

std::array<double, 10> quadratic_shape(const Vec4& b) {
    std::array<double, 10> n;
    for (int i = 0; i < 4; ++i) n[static_cast<std::size_t>(i)] = b[i] * (2 * b[i] - 1);
    for (std::size_t e = 0; e < 6; ++e) n[4 + e] = 4 * b[tet_edges[e][0]] * b[tet_edges[e][1]];
    return n;
}

Front::Front(const TetTree& tree, int order, int min_level, int max_level)
    : tree_(&tree),
      order_(order),
      status_(tree.tet_count(), Status::unreached),
      opened_(tree.vertex_count(), 0),
      vertex_state_(tree.vertex_count(), VertexState::absent),
      was_active_(tree.tet_count(), 0) {
    ENSURE(order == 1 || (order == 2 && tree.depth() >= 1), "order ", order, " depth ", tree.depth());
    max_level_ = std::clamp(max_level, 0, order == 1 ? tree.depth() : tree.depth() - 1);
    min_level_ = std::clamp(min_level, 0, max_level_);
    for (VertexId v : ids<VertexId>(tree.vertex_count(0))) touched_vertices_.push_back(v);
    for (TetId t : tree.level(0)) {
        status_[t] = Status::active;
        touched_tets_.push_back(t);
        if (order_ == 2) open(t, 1);
    }
    active_count_ = tree.root_count();
    for (int level = 0; level < min_level_; ++level)
        for (TetId t : tree.level(level)) split(t);
    commit();
}

std::array<VertexId, 10> Front::nodes(TetId t) const {
    std::array<VertexId, 10> n;
    std::copy(tree_->corners(t).begin(), tree_->corners(t).end(), n.begin());
    if (order_ == 2) std::copy(tree_->midpoints(t).begin(), tree_->midpoints(t).end(), n.begin() + 4);
    return n;
}

void Front::open(TetId t, int sign) {
    for (VertexId v : tree_->midpoints(t)) {
        opened_[v] = static_cast<std::uint16_t>(opened_[v] + sign);
        touched_vertices_.push_back(v);
    }
}

bool Front::split(TetId t) {
    if (!is_active(t) || tree_->level_of(t) >= max_level_) return false;
    status_[t] = Status::refined;
    active_count_ += 7;
    touched_tets_.push_back(t);
    if (order_ == 1) open(t, 1);
    for (TetId c : tree_->children(t)) {
        status_[c] = Status::active;
        touched_tets_.push_back(c);
        if (order_ == 2) open(c, 1);
    }
    if (order_ == 2) {
        for (TetId c : tree_->children(t))
            for (VertexId v : tree_->midpoints(c))
                for (TetId s : tree_->star(v))
                    if (!is_reached(s)) ensure_reached(tree_->parent(s));
    }
    return true;
}

void Front::ensure_reached(TetId t) {
    if (is_reached(t)) return;
    const TetId p = tree_->parent(t);
    ensure_reached(p);
    split(p);
}

bool Front::can_merge(TetId t) const {
    if (!is_refined(t)) return false;
    const int level = tree_->level_of(t);
    if (level < min_level_) return false;
    for (TetId c : tree_->children(t))
        if (!is_active(c)) return false;
    if (order_ == 1 || level + 2 >= tree_->depth()) return true;  // grandchildren have no nodes of their own
    for (TetId c : tree_->children(t))
        for (TetId g : tree_->children(c))
            for (VertexId w : tree_->midpoints(g))
                if (opened_[w] > 0) return false;
    return true;
}

void Front::merge(TetId t) {
    CHECK_DEBUG(can_merge(t), "tet ", t.value);
    status_[t] = Status::active;
    active_count_ -= 7;
    touched_tets_.push_back(t);
    if (order_ == 1) open(t, -1);
    for (TetId c : tree_->children(t)) {
        status_[c] = Status::unreached;
        touched_tets_.push_back(c);
        if (order_ == 2) open(c, -1);
    }
}

VertexState Front::state_from_star(VertexId v) const {
    const std::size_t star = tree_->star(v).size();
    if (opened_[v] == star) return VertexState::free;  // also the roots' corners, whose star is empty
    return opened_[v] == 0 ? VertexState::absent : VertexState::hanging;
}

const Front::Change& Front::commit() {
    change_.appeared.clear();
    change_.vanished.clear();
    change_.tied.clear();
    change_.activated.clear();
    if (touched_tets_.empty()) return change_;

    sort_unique(touched_tets_);
    bool tets_changed = false;
    for (TetId t : touched_tets_) {
        if (is_active(t) == (was_active_[t] != 0)) continue;
        tets_changed = true;
        was_active_[t] = is_active(t);
        if (is_active(t)) change_.activated.push_back(t);
    }
    if (tets_changed) {
        update_sorted(active_, change_.activated, [&](TetId t) { return is_active(t); });
        ++epoch_;
    }

    sort_unique(touched_vertices_);
    std::vector<VertexId> new_hanging;
    for (VertexId v : touched_vertices_) {
        const VertexState before = vertex_state_[v], now = state_from_star(v);
        if (before == now) continue;
        vertex_state_[v] = now;
        if (before == VertexState::absent) change_.appeared.push_back(v);
        if (now == VertexState::absent) change_.vanished.push_back(v);
        if (now == VertexState::hanging) new_hanging.push_back(v);
        if (before == VertexState::free && now == VertexState::hanging) change_.tied.push_back(v);
    }
    // `appeared` and `new_hanging` are ascending because touched_vertices_ is.
    update_sorted(vertices_, change_.appeared, [&](VertexId v) { return vertex_state_[v] != VertexState::absent; });
    std::erase_if(hanging_, [&](VertexId v) {
        return vertex_state_[v] != VertexState::hanging || std::binary_search(new_hanging.begin(), new_hanging.end(), v);
    });
    update_sorted(hanging_, new_hanging, [](VertexId) { return true; });
    touched_tets_.clear();
    touched_vertices_.clear();
    return change_;
}

std::optional<Front> Front::with_active(const std::vector<TetId>& active) const {
    std::vector<bool> refined(tree_->tet_count());
    for (TetId t : active) {
        if (t.value < 0 || t.index() >= tree_->tet_count()) return std::nullopt;
        while (!tree_->is_root(t)) {
            t = tree_->parent(t);
            if (refined[t.index()]) break;
            refined[t.index()] = true;
        }
    }
    std::optional<Front> front(std::in_place, *tree_, order_, min_level_, max_level_);
    for (TetId t : ids<TetId>(refined.size()))  // parents come before their children
        if (refined[t.index()] && front->is_active(t)) front->split(t);
    front->commit();
    if (front->active() != active) return std::nullopt;
    front->epoch_ = epoch_ + 1;
    return front;
}

Front::Point Front::locate(TetId leaf, const Vec4& barycentric) const {
    Point p{leaf, barycentric, {}, {}};
    while (!is_active(p.tet)) {
        ENSURE(!tree_->is_root(p.tet), "leaf ", leaf.value, " has no active ancestor");
        p.barycentric = barycentric_in_parent(tree_->child_number(p.tet), p.barycentric);
        p.tet = tree_->parent(p.tet);
    }
    p.nodes = nodes(p.tet);
    if (order_ == 1) {
        for (std::size_t i = 0; i < 4; ++i) p.weights[i] = p.barycentric[static_cast<int>(i)];
    } else {
        p.weights = quadratic_shape(p.barycentric);
    }
    return p;
}

void Front::validate() const {
    for (TetId t : ids<TetId>(tree_->tet_count())) {
        if (tree_->is_root(t)) {
            ENSURE(is_reached(t), "root ", t.value);
            continue;
        }
        ENSURE(is_reached(t) == is_refined(tree_->parent(t)), "tet ", t.value, " and its parent");
    }
    for (TetId t : ids<TetId>(tree_->tet_count())) {
        if (is_active(t) || is_refined(t)) ENSURE(tree_->level_of(t) <= max_level_, "tet ", t.value);
        ENSURE(!is_active(t) || tree_->level_of(t) >= min_level_, "tet ", t.value);
        ENSURE(std::binary_search(active_.begin(), active_.end(), t) == is_active(t), "tet ", t.value, " list");
    }
    ENSURE(active_count_ == active_.size(), active_count_, ' ', active_.size());
    ENSURE(std::is_sorted(vertices_.begin(), vertices_.end()) && std::is_sorted(hanging_.begin(), hanging_.end()), "");
    for (VertexId v : ids<VertexId>(tree_->vertex_count())) {
        std::size_t opened = 0;
        for (TetId s : tree_->star(v)) opened += order_ == 1 ? is_refined(s) : is_reached(s);
        ENSURE(opened == opened_[v], "vertex ", v.value, " counts ", opened, ' ', opened_[v]);
        ENSURE(state_from_star(v) == vertex_state_[v], "vertex ", v.value, " state");
        const bool exists = vertex_state_[v] != VertexState::absent;
        ENSURE(std::binary_search(vertices_.begin(), vertices_.end(), v) == exists, "vertex ", v.value, " list");
        ENSURE(std::binary_search(hanging_.begin(), hanging_.end(), v) == (vertex_state_[v] == VertexState::hanging),
               "vertex ", v.value, " hanging list");
        if (order_ != 2 || !exists) continue;
        for (TetId s : tree_->star(v))
            ENSURE(is_reached(s) || is_active(tree_->parent(s)), "balance at vertex ", v.value, " tet ", s.value);
    }
    for (TetId t : active_) {
        const auto n = nodes(t);
        for (int i = 0; i < nodes_per_tet(); ++i)
            ENSURE(vertex_state_[n[static_cast<std::size_t>(i)]] != VertexState::absent, "node of tet ", t.value);
    }
    for (VertexId v : hanging_)
        for (VertexId u : tree_->row(order_, v).vertices)
            ENSURE(vertex_state_[u] != VertexState::absent, "vertex ", v.value, " hangs on absent ", u.value);
}

}  // namespace tetfront
