#include "engine/mechanics/block_matrix.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"

namespace tetfront {

namespace {

constexpr std::size_t row_grain = 256;
using Float4 = float __attribute__((vector_size(16)));
using Double4 = double __attribute__((vector_size(32)));

Double4 load4(const float* p) {
    Float4 four;
    std::memcpy(&four, p, sizeof four);  // blocks of nine floats are not aligned
    return __builtin_convertvector(four, Double4);
}

/// Sum of 9 floats each, in double.
struct BlockSum {
    Double4 low = {0, 0, 0, 0}, high = {0, 0, 0, 0};
    double last = 0;
    void add(double weight, const float* p) {
        low += weight * load4(p);
        high += weight * load4(p + 4);
        last += weight * static_cast<double>(p[8]);
    }
    [[nodiscard]] double operator[](std::size_t m) const { return m < 4 ? low[m] : m < 8 ? high[m - 4] : last; }
};

}  // namespace

void BlockMatrix::expand(const Front& front) {
    terms_.clear();
    expansion_.resize(front.tree().vertex_count());
    std::vector<Term> sum;
    for (VertexId v : front.vertices()) {
        const auto begin = static_cast<std::uint32_t>(terms_.size());
        if (front.state(v) == VertexState::free) {
            if (dof_of_[v] >= 0) terms_.push_back({dof_of_[v], 1.0});
        } else {
            sum.clear();
            const TetTree::Row row = front.tree().row(front.order(), v);
            for (std::size_t k = 0; k < row.vertices.size(); ++k) {
                const Range r = expansion_[row.vertices[k]];  // older, hence done
                for (std::uint32_t n = r.begin; n < r.end; ++n) sum.push_back({terms_[n].dof, row.weights[k] * terms_[n].weight});
            }
            std::stable_sort(sum.begin(), sum.end(), [](const Term& a, const Term& b) { return a.dof < b.dof; });
            for (const Term& term : sum) {
                if (terms_.size() > begin && terms_.back().dof == term.dof) {
                    terms_.back().weight += term.weight;
                } else {
                    terms_.push_back(term);
                }
            }
        }
        expansion_[v] = {begin, static_cast<std::uint32_t>(terms_.size())};
    }
}

void BlockMatrix::build(const Front& front, const ElementSet& elements, const PerVertex<std::uint8_t>& pinned) {
    const TetTree& tree = front.tree();
    dof_of_.resize(tree.vertex_count());
    dof_vertex_.clear();
    for (VertexId v : front.vertices()) {
        const bool unknown = front.state(v) == VertexState::free && !pinned[v];
        dof_of_[v] = unknown ? static_cast<std::int32_t>(dof_vertex_.size()) : -1;
        if (unknown) dof_vertex_.push_back(v);
    }
    expand(front);

    // Every contribution of an element block to a matrix block, first bucketed by row, then sorted within its row.
    struct Entry {
        std::int32_t column;
        Source source;
    };
    const std::size_t dofs = dof_vertex_.size();
    const int nodes = elements.nodes();
    const auto for_each_entry = [&](const auto& visit) {
        for (std::size_t e = 0; e < elements.size(); ++e) {
            const auto node = front.nodes(elements.tets()[e]);
            for (int i = 0; i < nodes; ++i) {
                const Range ri = expansion_[node[static_cast<std::size_t>(i)]];
                for (int j = 0; j < nodes; ++j) {
                    const Range rj = expansion_[node[static_cast<std::size_t>(j)]];
                    if (ri.begin == ri.end || rj.begin == rj.end) continue;
                    const std::size_t offset = elements.block_offset(e, std::min(i, j), std::max(i, j));
                    for (std::uint32_t a = ri.begin; a < ri.end; ++a) {
                        for (std::uint32_t b = rj.begin; b < rj.end; ++b) {
                            const auto &ta = terms_[a], &tb = terms_[b];
                            visit(static_cast<std::size_t>(ta.dof),
                                  Entry{tb.dof, {static_cast<std::uint32_t>(offset), static_cast<float>(ta.weight * tb.weight), i > j}});
                        }
                    }
                }
            }
        }
    };
    std::vector<std::uint32_t> begin(dofs + 1, 0);
    for_each_entry([&](std::size_t row, const Entry&) { ++begin[row + 1]; });
    for (std::size_t r = 0; r < dofs; ++r) begin[r + 1] += begin[r];
    std::vector<Entry> entries(begin.back());
    {
        std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
        for_each_entry([&](std::size_t row, const Entry& entry) { entries[next[row]++] = entry; });
    }
    row_begin_.assign(dofs + 1, 0);
    parallel_for(dofs, row_grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) {
            const auto from = entries.begin() + begin[r], to = entries.begin() + begin[r + 1];
            std::stable_sort(from, to, [](const Entry& x, const Entry& y) { return x.column < y.column; });
            std::uint32_t blocks = 0;
            for (auto it = from; it != to; ++it) blocks += it == from || it->column != (it - 1)->column;
            row_begin_[r + 1] = blocks;
        }
    });
    for (std::size_t r = 0; r < dofs; ++r) row_begin_[r + 1] += row_begin_[r];

    column_.resize(row_begin_.back());
    diagonal_.resize(dofs);
    source_begin_.resize(column_.size() + 1);
    source_.resize(entries.size());
    value_.assign(column_.size() * 9 + 3, 0.0F);
    parallel_for(dofs, row_grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) {
            std::uint32_t block = row_begin_[r];
            for (std::uint32_t n = begin[r]; n < begin[r + 1]; ++n) {
                if (n == begin[r] || entries[n].column != entries[n - 1].column) {
                    if (entries[n].column == static_cast<std::int32_t>(r)) diagonal_[r] = block;
                    column_[block] = entries[n].column;
                    source_begin_[block++] = n;
                }
                source_[n] = entries[n].source;
            }
        }
    });
    source_begin_.back() = static_cast<std::uint32_t>(entries.size());
}

void BlockMatrix::fill(const ElementSet& elements) {
    const float* blocks = elements.blocks();
    parallel_for(column_.size(), 2048, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            // Blocks (i, j) and (j, i) add the same numbers in the same order: the matrix stays symmetric to the last bit.
            BlockSum straight, transposed;
            for (std::uint32_t n = source_begin_[k]; n < source_begin_[k + 1]; ++n) {
                const Source& s = source_[n];
                (s.transposed ? transposed : straight).add(static_cast<double>(s.weight), blocks + s.offset);
            }
            float* v = &value_[k * 9];
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t r = 0; r < 3; ++r) v[3 * c + r] = static_cast<float>(straight[3 * c + r] + transposed[3 * r + c]);
        }
    });
}

void BlockMatrix::add_point(std::span<const VertexId> nodes, std::span<const double> weights, const Mat3& block) {
    thread_local std::vector<Term> w;  // kept to save allocations
    w.clear();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Range r = expansion_[nodes[i]];
        for (std::uint32_t n = r.begin; n < r.end; ++n) w.push_back({terms_[n].dof, weights[i] * terms_[n].weight});
    }
    for (const Term& a : w) {
        for (const Term& b : w) {
            const auto row = static_cast<std::size_t>(a.dof);
            const auto from = column_.begin() + row_begin_[row], to = column_.begin() + row_begin_[row + 1];
            const auto it = std::lower_bound(from, to, b.dof);
            ENSURE(it != to && *it == b.dof, "the point is not inside one active tet");
            float* v = &value_[static_cast<std::size_t>(it - column_.begin()) * 9];
            for (int m = 0; m < 9; ++m) v[m] += static_cast<float>(a.weight * b.weight * block.data()[m]);
        }
    }
}

void BlockMatrix::multiply(const DofVector& p, DofVector& q) const {
    parallel_for(size(), row_grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) {
            // A sum for each column: three short chains of multiply-adds instead of a long one that waits for its latency. The
            // fourth lane holds the next column's first number and is dropped. (Six chains gained nothing more.)
            Double4 x_sum = {}, y_sum = {}, z_sum = {};
            for (std::uint32_t k = row_begin_[r]; k < row_begin_[r + 1]; ++k) {
                const float* v = &value_[static_cast<std::size_t>(k) * 9];
                const double* x = p[static_cast<std::size_t>(column_[k])].data();
                x_sum += load4(v) * x[0];
                y_sum += load4(v + 3) * x[1];
                z_sum += load4(v + 6) * x[2];
            }
            const Double4 total = x_sum + y_sum + z_sum;
            q[r] = Vec3(total[0], total[1], total[2]);
        }
    });
}

Mat3 BlockMatrix::diagonal_block(std::size_t dof) const { return block(dof, dof); }

Mat3 BlockMatrix::block(std::size_t row, std::size_t column) const {
    const auto from = column_.begin() + row_begin_[row], to = column_.begin() + row_begin_[row + 1];
    const auto it = std::lower_bound(from, to, static_cast<std::int32_t>(column));
    Mat3 m = Mat3::Zero();
    if (it == to || *it != static_cast<std::int32_t>(column)) return m;
    const float* v = &value_[static_cast<std::size_t>(it - column_.begin()) * 9];
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) m(r, c) = static_cast<double>(v[3 * c + r]);
    return m;
}

std::size_t BlockMatrix::memory_bytes() const {
    return column_.capacity() * sizeof(std::int32_t) + source_.capacity() * sizeof(Source) + value_.capacity() * sizeof(float) +
           (row_begin_.capacity() + source_begin_.capacity() + diagonal_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace tetfront
