#pragma once
// The symmetric system matrix of a front on its unknowns: P^T (stiffness_scale K + mass_scale M) P in 3x3 blocks, and
// the numbering of those unknowns.
//
// Unknowns (dofs) are the free vertices that are not pinned. Which element blocks make up which matrix block, and with
// which weight (1, or products of hanging-row weights), is worked out once per front; filling the matrix is then one
// gather per block in a fixed order: parallel, without atomics, and the same bits for any number of threads.
// Values are floats (half the memory traffic); products are summed in double.
//
//     BlockMatrix matrix;
//     matrix.build(front, elements, pinned);       // after the front changed
//     elements.evaluate({.tangent = true, ...});
//     matrix.fill(elements);
//     matrix.multiply(p, q);                       // q = A p, one Vec3 per dof

#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

using DofVector = std::vector<Vec3>;

class BlockMatrix {
 public:
    /// pinned: [V of the tree], nonzero where a vertex does not move.
    void build(const Front& front, const ElementSet& elements, const PerVertex<std::uint8_t>& pinned);
    void fill(const ElementSet& elements);
    /// Adds w w^T times a symmetric 3x3 block, w = P^T weights: a spring or contact at a point of one active tet.
    void add_point(std::span<const VertexId> nodes, std::span<const double> weights, const Mat3& block);

    [[nodiscard]] std::size_t size() const { return dof_vertex_.size(); }
    [[nodiscard]] std::size_t block_count() const { return column_.size(); }
    /// Vertex of each dof, ascending.
    [[nodiscard]] const std::vector<VertexId>& vertices() const { return dof_vertex_; }
    void multiply(const DofVector& p, DofVector& q) const;
    [[nodiscard]] Mat3 diagonal_block(std::size_t dof) const;
    /// Block (row, column), zero when it is not stored. For tests.
    [[nodiscard]] Mat3 block(std::size_t row, std::size_t column) const;
    [[nodiscard]] std::size_t memory_bytes() const;

 private:
    struct Source {
        std::uint32_t offset;     // into ElementSet::blocks()
        float weight;
        std::uint32_t transposed; // 0 or 1
    };
    /// Every vertex of the front as a combination of dofs: the rows of P without pinned columns.
    struct Term {
        std::int32_t dof;
        double weight;
    };
    struct Range {
        std::uint32_t begin, end;
    };
    void expand(const Front& front);

    std::vector<VertexId> dof_vertex_;            // [dofs]
    PerVertex<std::int32_t> dof_of_;              // [V of the tree] valid for existing vertices; -1 hanging or pinned
    std::vector<Term> terms_;
    PerVertex<Range> expansion_;                  // [V of the tree] into terms_, valid for existing vertices
    std::vector<std::uint32_t> row_begin_;        // [dofs+1]
    std::vector<std::int32_t> column_;            // [blocks]
    std::vector<std::uint32_t> diagonal_;         // [dofs] index of the diagonal block
    std::vector<std::uint32_t> source_begin_;     // [blocks+1]
    std::vector<Source> source_;
    std::vector<float> value_;                    // [blocks][9] column-major, and some more so that four can be read from each column
};

}  // namespace tetfront
