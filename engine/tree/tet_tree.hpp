#pragma once
// The hierarchy of tets: every level of an 8-subdivision of the input mesh, built once and never changed.
//
// Level 0 is the input mesh (the roots). A tet's eight children are its four corner tets and the octahedron between
// them cut in four along one diagonal, in the order of Bey 1995 (see also Liu & Joe 1995), which gives at most three
// congruence classes per root, so the worst quality does not fall with depth.
//
// Tets are numbered level by level, the children of a tet one after another: parent and children are arithmetic.
// A vertex made by refinement is the midpoint of its `split_edge`, whose ends are older (smaller ids). Its `star` is
// every tet of the level above the vertex that has this edge.
//
//     TetTree tree(box_mesh(...), 3);                  // levels 0..3
//     for (TetId t : tree.level(1))                    // the tets of level 1
//         for (TetId child : tree.children(t)) ...     // 8 of them
//     tree.midpoints(t)[edge]                          // the vertex that splits local edge `edge` of t
//
// Local edges: 01 02 03 12 13 23 (`tet_edges`).

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/mesh/tet_mesh.hpp"

namespace tetfront {

inline constexpr std::array<std::array<int, 2>, 6> tet_edges = {{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Local nodes of the children: 0..3 corners of the parent, 4..9 its edge midpoints in the order of tet_edges.
/// Bey's children; where his order turns a child inside out two of its nodes are swapped so that all volumes are
/// positive and the diagonal that the next level cuts along (nodes 0-2 and 1-3) stays the same.
extern const std::array<std::array<int, 4>, 8> child_nodes;

/// Parent's barycentric coordinates of a point given by those of one of its children.
Vec4 barycentric_in_parent(int child, const Vec4& in_child);

class TetTree {
 public:
    /// roots: a valid mesh (see validate()). depth: number of subdivisions, 0..8; throws InputError when the tree
    /// would have more than 2^28 tets.
    TetTree(TetMesh roots, int depth);

    [[nodiscard]] int depth() const { return depth_; }
    [[nodiscard]] std::size_t vertex_count() const { return rest_.size(); }
    [[nodiscard]] std::size_t tet_count() const { return corners_.size(); }
    [[nodiscard]] std::size_t root_count() const { return level_begin_[1]; }
    /// Vertices that exist at `level`: ids [0, vertex_count(level)).
    [[nodiscard]] std::size_t vertex_count(int level) const { return vertex_end_[static_cast<std::size_t>(level)]; }
    [[nodiscard]] std::size_t tet_count(int level) const { return level_begin_[level + 1] - level_begin_[level]; }
    [[nodiscard]] auto level(int level) const {
        return ids<TetId>(static_cast<std::int64_t>(level_begin_[level]), static_cast<std::int64_t>(level_begin_[level + 1]));
    }
    [[nodiscard]] int level_of(TetId t) const {
        int level = 0;
        while (t.index() >= level_begin_[level + 1]) ++level;
        return level;
    }
    /// Level at which the vertex appears: 0 for the roots' corners.
    [[nodiscard]] int level_of(VertexId v) const {
        int level = 0;
        while (v.index() >= vertex_end_[static_cast<std::size_t>(level)]) ++level;
        return level;
    }
    [[nodiscard]] bool is_leaf(TetId t) const { return t.index() >= level_begin_[depth_]; }
    [[nodiscard]] bool is_root(TetId t) const { return t.index() < level_begin_[1]; }
    [[nodiscard]] TetId parent(TetId t) const {
        const int level = level_of(t);
        return level == 0 ? TetId{}
                          : TetId(level_begin_[level - 1] + (t.index() - level_begin_[level]) / 8);
    }
    [[nodiscard]] int child_number(TetId t) const {
        return static_cast<int>((t.index() - level_begin_[level_of(t)]) % 8);
    }
    /// t must not be a leaf.
    [[nodiscard]] auto children(TetId t) const {
        const int level = level_of(t);
        const std::int64_t first =
            static_cast<std::int64_t>(level_begin_[level + 1] + 8 * (t.index() - level_begin_[level]));
        return ids<TetId>(first, first + 8);
    }

    [[nodiscard]] const std::array<VertexId, 4>& corners(TetId t) const { return corners_[t]; }
    /// Vertices that split the six edges of t, in the order of tet_edges. t must not be a leaf.
    [[nodiscard]] const std::array<VertexId, 6>& midpoints(TetId t) const { return midpoints_[t]; }
    [[nodiscard]] const Vec3& rest(VertexId v) const { return rest_[v]; }  // [m]
    [[nodiscard]] const PerVertex<Vec3>& rest() const { return rest_; }
    [[nodiscard]] double volume(TetId t) const { return volume_[t]; }  // [m^3], > 0
    [[nodiscard]] std::int32_t region(TetId t) const;                  // of its root

    /// Ends of the edge that v splits, both older than v. v must not be a root vertex.
    [[nodiscard]] const std::array<VertexId, 2>& split_edge(VertexId v) const { return split_edge_[v]; }
    /// Tets of level_of(v) - 1 that have split_edge(v); empty for a root vertex.
    [[nodiscard]] std::span<const TetId> star(VertexId v) const {
        return {star_tets_.data() + star_begin_[v.index()], star_tets_.data() + star_begin_[v.index() + 1]};
    }

    /// The row that gives a vertex from older ones when nothing simulates it:
    ///     x_v = sum_k weights[k] x_{vertices[k]}.
    /// order 1: the midpoint of its split edge. order 2: the quadratic interpolation of the tet that v is inside of,
    /// whose nodes are its corners and midpoints; empty for vertices of level 0 and 1, which are nodes of the roots.
    struct Row {
        std::span<const VertexId> vertices;
        std::span<const double> weights;
    };
    [[nodiscard]] Row row(int order, VertexId v) const;

    /// Throws LogicError when an invariant does not hold (volumes, numbering, stars, rows). Cost: the whole tree.
    void validate() const;
    [[nodiscard]] std::size_t memory_bytes() const;

 private:
    void subdivide(int level);
    void build_stars();
    void build_quadratic_rows();

    int depth_;
    std::vector<std::size_t> level_begin_;           // [depth+2] first tet of a level
    std::vector<std::size_t> vertex_end_;            // [depth+1] one past the last vertex of a level
    PerTet<std::array<VertexId, 4>> corners_;        // [T]
    PerTet<std::array<VertexId, 6>> midpoints_;      // [T - leaves]
    PerTet<double> volume_;                          // [T]
    PerTet<std::int32_t> root_region_;               // [roots] or empty
    PerVertex<Vec3> rest_;                           // [V]
    PerVertex<std::array<VertexId, 2>> split_edge_;  // [V] invalid ids for root vertices
    std::vector<std::uint32_t> star_begin_;          // [V+1]
    std::vector<TetId> star_tets_;
    std::vector<std::uint32_t> quadratic_begin_;     // [V+1]
    std::vector<VertexId> quadratic_vertices_;
    std::vector<double> quadratic_weights_;
};

}  // namespace tetfront
