#include "engine/tree/tet_tree.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "engine/base/error.hpp"

namespace tetfront {

// Bey's T6 and T8 are inside out: their nodes 0 and 2 are swapped here.
const std::array<std::array<int, 4>, 8> child_nodes = {{
    {0, 4, 5, 6},
    {4, 1, 7, 8},
    {5, 7, 2, 9},
    {6, 8, 9, 3},
    {4, 5, 6, 8},
    {7, 5, 4, 8},
    {5, 6, 8, 9},
    {8, 7, 5, 9},
}};

namespace {

/// Barycentric coordinates in the tet of its ten local nodes.
Vec4 node_barycentric(int node) {
    Vec4 b = Vec4::Zero();
    if (node < 4) {
        b[node] = 1;
    } else {
        for (int end : tet_edges[static_cast<std::size_t>(node - 4)]) b[end] = 0.5;
    }
    return b;
}

/// Finds or makes the midpoint of an edge: entries of all edges with the same lower end are chained.
class EdgeMidpoints {
 public:
    explicit EdgeMidpoints(std::size_t vertex_count) : head_(vertex_count, -1) {}

    /// Returns the midpoint of (a, b); calls make() for its id when the edge is new.
    template <class Make>
    VertexId find_or_make(VertexId a, VertexId b, const Make& make) {
        if (b < a) std::swap(a, b);
        for (std::int32_t e = head_[a]; e >= 0; e = entries_[static_cast<std::size_t>(e)].next) {
            if (entries_[static_cast<std::size_t>(e)].other == b) return entries_[static_cast<std::size_t>(e)].midpoint;
        }
        const VertexId midpoint = make(a, b);
        entries_.push_back({b, midpoint, head_[a]});
        head_[a] = static_cast<std::int32_t>(entries_.size()) - 1;
        return midpoint;
    }

 private:
    struct Entry {
        VertexId other, midpoint;
        std::int32_t next;
    };
    PerVertex<std::int32_t> head_;
    std::vector<Entry> entries_;
};

}  // namespace

Vec4 barycentric_in_parent(int child, const Vec4& in_child) {
    Vec4 b = Vec4::Zero();
    for (int i = 0; i < 4; ++i) {
        const int node = child_nodes[static_cast<std::size_t>(child)][static_cast<std::size_t>(i)];
        b += in_child[i] * node_barycentric(node);
    }
    return b;
}

TetTree::TetTree(TetMesh roots, int depth)
    : depth_(depth),
      corners_(std::move(roots.corners)),
      root_region_(std::move(roots.region)),
      rest_(std::move(roots.positions)) {
    ENSURE(depth >= 0 && depth <= 8, "depth ", depth);
    double tets = 0;
    for (int level = 0; level <= depth; ++level) tets += static_cast<double>(corners_.size()) * std::pow(8.0, level);
    if (corners_.empty() || tets > std::pow(2.0, 28)) {
        throw InputError("", "", "a tree of " + std::to_string(corners_.size()) + " roots and " + std::to_string(depth) +
                                     " levels would have " + std::to_string(static_cast<long long>(tets)) + " tets",
                         "at least 1 and at most 2^28 are possible: use fewer roots or levels");
    }
    level_begin_ = {0, corners_.size()};
    vertex_end_ = {rest_.size()};
    split_edge_.assign(rest_.size(), {VertexId{}, VertexId{}});
    for (int level = 0; level < depth_; ++level) subdivide(level);

    volume_.resize(corners_.size());
    for (TetId t : ids<TetId>(corners_.size())) {
        const auto& c = corners_[t];
        volume_[t] = signed_volume(rest_[c[0]], rest_[c[1]], rest_[c[2]], rest_[c[3]]);
    }
    build_stars();
    build_quadratic_rows();
}

void TetTree::subdivide(int level) {
    EdgeMidpoints edges(rest_.size());
    const auto make_midpoint = [this](VertexId a, VertexId b) {
        rest_.push_back(0.5 * (rest_[a] + rest_[b]));
        split_edge_.push_back({a, b});
        return VertexId(static_cast<std::int64_t>(rest_.size()) - 1);
    };
    const std::size_t begin = level_begin_[static_cast<std::size_t>(level)], end = corners_.size();
    corners_.reserve(end + 8 * (end - begin));
    for (std::size_t i = begin; i < end; ++i) {
        const TetId t(static_cast<std::int64_t>(i));
        const std::array<VertexId, 4> corner = corners_[t];
        std::array<VertexId, 10> node;
        std::copy(corner.begin(), corner.end(), node.begin());
        for (std::size_t e = 0; e < 6; ++e) {
            node[4 + e] = edges.find_or_make(corner[static_cast<std::size_t>(tet_edges[e][0])],
                                             corner[static_cast<std::size_t>(tet_edges[e][1])], make_midpoint);
        }
        midpoints_.push_back({node[4], node[5], node[6], node[7], node[8], node[9]});
        for (const auto& child : child_nodes) {
            corners_.push_back({node[static_cast<std::size_t>(child[0])], node[static_cast<std::size_t>(child[1])],
                                node[static_cast<std::size_t>(child[2])], node[static_cast<std::size_t>(child[3])]});
        }
    }
    level_begin_.push_back(corners_.size());
    vertex_end_.push_back(rest_.size());
}

void TetTree::build_stars() {
    star_begin_.assign(rest_.size() + 1, 0);
    for (const auto& mid : midpoints_)
        for (VertexId v : mid) ++star_begin_[v.index() + 1];
    for (std::size_t v = 0; v < rest_.size(); ++v) star_begin_[v + 1] += star_begin_[v];
    star_tets_.resize(star_begin_.back());
    std::vector<std::uint32_t> next(star_begin_.begin(), star_begin_.end() - 1);
    for (TetId t : ids<TetId>(midpoints_.size()))
        for (VertexId v : midpoints_[t]) star_tets_[next[v.index()]++] = t;
}

void TetTree::build_quadratic_rows() {
    quadratic_begin_.assign(1, 0);
    const std::size_t first = depth_ == 0 ? rest_.size() : vertex_end_[1];
    quadratic_begin_.resize(first + 1, 0);
    for (VertexId v : ids<VertexId>(static_cast<std::int64_t>(first), static_cast<std::int64_t>(rest_.size()))) {
        const TetId p = parent(star(v).front());
        std::array<VertexId, 10> node;
        std::copy(corners_[p].begin(), corners_[p].end(), node.begin());
        std::copy(midpoints_[p].begin(), midpoints_[p].end(), node.begin() + 4);
        Vec4 b = Vec4::Zero();  // of v in p
        for (VertexId end : split_edge_[v]) {
            b += 0.5 * node_barycentric(static_cast<int>(std::find(node.begin(), node.end(), end) - node.begin()));
        }
        for (std::size_t i = 0; i < 10; ++i) {
            double w;
            if (i < 4) {
                w = b[static_cast<int>(i)] * (2 * b[static_cast<int>(i)] - 1);
            } else {
                w = 4 * b[tet_edges[i - 4][0]] * b[tet_edges[i - 4][1]];
            }
            if (w != 0) {
                quadratic_vertices_.push_back(node[i]);
                quadratic_weights_.push_back(w);
            }
        }
        quadratic_begin_.push_back(static_cast<std::uint32_t>(quadratic_vertices_.size()));
    }
}

TetTree::Row TetTree::row(int order, VertexId v) const {
    static constexpr std::array<double, 2> halves = {0.5, 0.5};
    if (order == 1) {
        if (!split_edge_[v][0].valid()) return {};
        return {split_edge_[v], halves};
    }
    const std::size_t begin = quadratic_begin_[v.index()], end = quadratic_begin_[v.index() + 1];
    return {{quadratic_vertices_.data() + begin, end - begin}, {quadratic_weights_.data() + begin, end - begin}};
}

std::int32_t TetTree::region(TetId t) const {
    if (root_region_.empty()) return 0;
    while (!is_root(t)) t = parent(t);
    return root_region_[t];
}

void TetTree::validate() const {
    for (TetId t : ids<TetId>(tet_count())) {
        ENSURE(volume_[t] > 0, "tet ", t.value, " volume ", volume_[t]);
        if (is_leaf(t)) continue;
        double sum = 0;
        int number = 0;
        for (TetId c : children(t)) {
            ENSURE(parent(c) == t && child_number(c) == number++, "tet ", t.value, " child ", c.value);
            sum += volume_[c];
        }
        ENSURE(std::abs(sum - volume_[t]) <= 1e-9 * volume_[t], "tet ", t.value, " children's volume ", sum);
        for (std::size_t e = 0; e < 6; ++e) {
            const VertexId v = midpoints_[t][e];
            const auto s = star(v);
            ENSURE(std::find(s.begin(), s.end(), t) != s.end(), "tet ", t.value, " not in the star of ", v.value);
        }
    }
    for (VertexId v : ids<VertexId>(vertex_count())) {
        const int level = level_of(v);
        if (level == 0) {
            ENSURE(star(v).empty(), "root vertex ", v.value);
            continue;
        }
        ENSURE(split_edge_[v][0] < split_edge_[v][1] && split_edge_[v][1] < v, "vertex ", v.value);
        for (TetId t : star(v)) ENSURE(level_of(t) == level - 1, "vertex ", v.value, " star tet ", t.value);
        for (int order : {1, 2}) {
            const Row r = row(order, v);
            if (r.vertices.empty()) continue;
            Vec3 x = Vec3::Zero();
            for (std::size_t k = 0; k < r.vertices.size(); ++k) {
                ENSURE(r.vertices[k] < v, "vertex ", v.value, " depends on a younger one");
                x += r.weights[k] * rest_[r.vertices[k]];
            }
            ENSURE((x - rest_[v]).norm() <= 1e-9 * (1 + rest_[v].norm()), "vertex ", v.value, " row of order ", order);
        }
    }
}

std::size_t TetTree::memory_bytes() const {
    const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v.front()); };
    return bytes(corners_) + bytes(midpoints_) + bytes(volume_) + bytes(rest_) + bytes(split_edge_) + bytes(star_begin_) +
           bytes(star_tets_) + bytes(quadratic_begin_) + bytes(quadratic_vertices_) + bytes(quadratic_weights_);
}

}  // namespace tetfront
