#pragma once
// The front: the cut through the tree whose tets are simulated now ([Imai] section 3.2), and the map P from the free
// vertices to all of its vertices.
//
// A tet of the tree is active (in the front), refined (the front runs below it) or unreached (below the front). Order 1
// simulates linear tets on their corners; order 2 quadratic tets on their corners and edge midpoints, the tree's own
// vertices. A vertex that refinement made is, with its star as in TetTree,
//
//     order 1                                      order 2
//     absent   no tet of the star is refined       no tet of the star is reached (active or refined)
//     free     all of them are                     all of them are
//     hanging  otherwise                           otherwise
//
// A hanging vertex is not an unknown: it follows TetTree::row(order, v). Rows point to older vertices only, so one
// ascending pass evaluates x = P x_free (prolong) and one descending pass f_free = P^T f (restrict), the Galerkin
// condition. The same rows give absent vertices their place. Order 2 keeps the front 2:1 balanced: the parent of an
// unreached tet in the star of an existing vertex is active, so that hanging rows reach one level up only.
//
//     Front front(tree, 2, 0, 99);
//     front.split(t);  front.split(u);  if (front.can_merge(p)) front.merge(p);
//     const Front::Change& change = front.commit();       // what appeared and vanished; lists are up to date again
//     for (VertexId v : change.appeared) x[v] = front.interpolate(x, v);
//     front.prolong(x);                                   // hanging vertices
//
// Cost: split, merge and commit follow what changes, plus one pass over the front; never the tree.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/tree/tet_tree.hpp"

namespace tetfront {

enum class VertexState : std::uint8_t { absent, hanging, free };

class Front {
 public:
    /// order 1 or 2. Starts with all tets of min_level active. max_level is clamped to the deepest level that can be
    /// active (the leaves for order 1, one above for order 2), min_level to max_level. Order 2 needs depth >= 1.
    Front(const TetTree& tree, int order, int min_level, int max_level);

    [[nodiscard]] const TetTree& tree() const { return *tree_; }
    [[nodiscard]] int order() const { return order_; }
    [[nodiscard]] int min_level() const { return min_level_; }
    [[nodiscard]] int max_level() const { return max_level_; }
    [[nodiscard]] int nodes_per_tet() const { return order_ == 1 ? 4 : 10; }
    /// Corners, then (order 2) edge midpoints; entries beyond nodes_per_tet() are invalid.
    [[nodiscard]] std::array<VertexId, 10> nodes(TetId t) const;

    [[nodiscard]] bool is_active(TetId t) const { return status_[t] == Status::active; }
    [[nodiscard]] bool is_refined(TetId t) const { return status_[t] == Status::refined; }
    [[nodiscard]] bool is_reached(TetId t) const { return status_[t] != Status::unreached; }
    [[nodiscard]] VertexState state(VertexId v) const { return vertex_state_[v]; }

    /// Replaces an active tet by its children; for order 2 also splits what the balance asks for.
    /// False, and nothing changes, when t is not active or the children would be below max_level.
    bool split(TetId t);
    /// True when all children of t are active, t is not above min_level and (order 2) the balance allows it.
    [[nodiscard]] bool can_merge(TetId t) const;
    /// Replaces the children of t by t. Needs can_merge(t).
    void merge(TetId t);

    struct Change {
        std::vector<VertexId> appeared;  // ascending: absent before, free or hanging now
        std::vector<VertexId> vanished;  // ascending: existed before, absent now
        std::vector<VertexId> tied;      // ascending: free before, hanging now
        std::vector<TetId> activated;    // ascending
        [[nodiscard]] bool any() const { return !activated.empty(); }
    };
    /// Brings the lists below up to date after splits and merges and says what changed since the last call.
    const Change& commit();

    [[nodiscard]] const std::vector<TetId>& active() const { return active_; }          // ascending
    /// Active tets right now, also between split() or merge() and commit().
    [[nodiscard]] std::size_t active_count() const { return active_count_; }
    [[nodiscard]] const std::vector<VertexId>& vertices() const { return vertices_; }    // free and hanging, ascending
    [[nodiscard]] const std::vector<VertexId>& hanging() const { return hanging_; }      // ascending
    [[nodiscard]] std::size_t free_count() const { return vertices_.size() - hanging_.size(); }
    /// The front with these active tets on the same tree, of the same order and levels, with the next epoch; nothing when
    /// they are no such front: a branch is missed or met twice, a level is out of bounds, the balance does not hold.
    /// active: any numbers. Cost: the tree.
    [[nodiscard]] std::optional<Front> with_active(const std::vector<TetId>& active) const;
    /// Grows by one with each commit() that changed something.
    [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

    /// Row of v evaluated in x; v's own entry is not read.
    template <class T>
    [[nodiscard]] T interpolate(const PerVertex<T>& x, VertexId v) const {
        const TetTree::Row row = tree_->row(order_, v);
        T sum = row.weights[0] * x[row.vertices[0]];
        for (std::size_t k = 1; k < row.vertices.size(); ++k) sum += row.weights[k] * x[row.vertices[k]];
        return sum;
    }
    /// Writes the hanging entries of x: x = P x_free.
    template <class T>
    void prolong(PerVertex<T>& x) const {
        for (VertexId v : hanging_) x[v] = interpolate(x, v);
    }
    /// f_free = P^T f: moves the hanging entries of f to what they hang on and zeroes them.
    template <class T>
    void restrict_to_free(PerVertex<T>& f) const {
        for (auto v = hanging_.rbegin(); v != hanging_.rend(); ++v) {
            const TetTree::Row row = tree_->row(order_, *v);
            for (std::size_t k = 0; k < row.vertices.size(); ++k) f[row.vertices[k]] += row.weights[k] * f[*v];
            f[*v] = 0 * f[*v];
        }
    }

    /// A material point in the front: the active tet that contains a leaf and the shape functions there.
    struct Point {
        TetId tet;
        Vec4 barycentric;                // in tet
        std::array<VertexId, 10> nodes;  // nodes_per_tet() of them
        std::array<double, 10> weights;  // shape functions, sum 1
    };
    [[nodiscard]] Point locate(TetId leaf, const Vec4& barycentric) const;

    /// Throws LogicError when an invariant does not hold: every root-to-leaf path meets the front exactly once, vertex
    /// states agree with the stars, lists agree with the states, the balance holds. Cost: the whole tree.
    void validate() const;

 private:
    enum class Status : std::uint8_t { unreached, active, refined };

    void open(TetId t, int sign);
    void ensure_reached(TetId t);
    [[nodiscard]] VertexState state_from_star(VertexId v) const;

    const TetTree* tree_;
    int order_, min_level_, max_level_;
    PerTet<Status> status_;               // [T of the tree]
    PerVertex<std::uint16_t> opened_;     // [V of the tree] opened tets in the star
    PerVertex<VertexState> vertex_state_; // [V of the tree] as of the last commit
    std::vector<TetId> active_;
    std::vector<VertexId> vertices_, hanging_;
    std::size_t active_count_ = 0;
    std::uint32_t epoch_ = 0;

    std::vector<VertexId> touched_vertices_;  // since the last commit, with repetitions
    std::vector<TetId> touched_tets_;
    PerTet<std::uint8_t> was_active_;         // [T of the tree] as of the last commit
    Change change_;
};

/// Quadratic shape functions of the ten nodes at barycentric coordinates b.
std::array<double, 10> quadratic_shape(const Vec4& b);

}  // namespace tetfront
