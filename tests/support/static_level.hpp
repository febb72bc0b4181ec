#pragma once
// Linear static solve on one uniform level of a tree, for tests and reports: clamped where x = 0, loaded by gravity
// along -z, by a sparse direct factorisation. Slow and independent of the simulation's kernels on purpose.
//
//     std::vector<Vec3> u = solve_static_level(tree, 1, 2, matrices.elasticity, density);   // level 1, quadratic tets

#include "engine/base/error.hpp"
#include "engine/mechanics/cell_problem.hpp"
#include "engine/tree/tet_tree.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <array>
#include <vector>

namespace tetfront {

/// order 2 takes the vertices of level + 1 as nodes: level < depth. Returns the displacement [m] of each of the tree's
/// vertices, zero where it is no node.
inline std::vector<Vec3> solve_static_level(const TetTree& tree, int level, int order, const PooledPerTet<Sym6>& elasticity,
                                            const PerTet<double>& density) {
    const std::size_t nodes = order == 1 ? 4 : 10;
    std::vector<int> unknown(tree.vertex_count(), -1);
    int count = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count(order == 1 ? level : level + 1)))
        if (tree.rest(v)[0] > 1e-9) unknown[v.index()] = count++;

    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * count);
    for (TetId t : tree.level(level)) {
        std::array<VertexId, 10> node;
        std::array<Vec3, 4> x;
        for (std::size_t i = 0; i < 4; ++i) {
            node[i] = tree.corners(t)[i];
            x[i] = tree.rest(node[i]);
        }
        if (order == 2)
            for (std::size_t e = 0; e < 6; ++e) node[4 + e] = tree.midpoints(t)[e];
        const auto g = corner_gradients(x);
        Eigen::MatrixXd k = Eigen::MatrixXd::Zero(30, 30);
        const int points = order == 1 ? 1 : 4;
        for (int point = 0; point < points; ++point) {
            Vec4 b = Vec4::Constant(order == 1 ? 0.25 : 0.13819660112501051518);
            if (order == 2) b[point] = 0.58541019662496845446;
            Eigen::MatrixXd strain = Eigen::MatrixXd::Zero(6, 30);
            for (std::size_t i = 0; i < nodes; ++i) {
                Vec3 d;  // gradient of the shape function
                if (order == 1) {
                    d = g.col(static_cast<int>(i));
                } else if (i < 4) {
                    d = (4 * b[static_cast<int>(i)] - 1) * g.col(static_cast<int>(i));
                } else {
                    const auto [p, q] = tet_edges[i - 4];
                    d = 4 * (b[p] * g.col(q) + b[q] * g.col(p));
                }
                const int c = 3 * static_cast<int>(i);
                for (int r = 0; r < 3; ++r) strain(r, c + r) = d[r];
                strain(3, c + 1) = strain(4, c) = d[2];
                strain(3, c + 2) = strain(5, c) = d[1];
                strain(4, c + 2) = strain(5, c + 1) = d[0];
            }
            k += tree.volume(t) / points * strain.transpose() * elasticity[t].matrix() * strain;
        }
        for (std::size_t i = 0; i < nodes; ++i) {
            const int row = unknown[node[i].index()];
            if (row < 0) continue;
            // Integral of the shape function: order 2 corners -1/20, midpoints 1/5.
            const double share = order == 1 ? 0.25 : i < 4 ? -0.05 : 0.2;
            load[3 * row + 2] -= share * tree.volume(t) * density[t] * 9.81;
            for (std::size_t j = 0; j < nodes; ++j) {
                const int column = unknown[node[j].index()];
                if (column < 0) continue;
                for (int r = 0; r < 3; ++r)
                    for (int c = 0; c < 3; ++c)
                        entries.emplace_back(3 * row + r, 3 * column + c,
                                             k(3 * static_cast<int>(i) + r, 3 * static_cast<int>(j) + c));
            }
        }
    }
    Eigen::SparseMatrix<double> matrix(3 * count, 3 * count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
    ENSURE(factor.info() == Eigen::Success, "stiffness matrix is not positive definite");
    const Eigen::VectorXd u = factor.solve(load);
    std::vector<Vec3> displacement(tree.vertex_count(), Vec3::Zero());
    for (std::size_t v = 0; v < unknown.size(); ++v)
        if (unknown[v] >= 0) displacement[v] = u.segment<3>(3 * unknown[v]);
    return displacement;
}

/// Mean deflection [m] along -z of the root vertices at the far end in x, which every level has.
inline double tip_deflection(const TetTree& tree, const std::vector<Vec3>& displacement) {
    double far = 0, sum = 0;
    int count = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count(0))) far = std::max(far, tree.rest(v)[0]);
    for (VertexId v : ids<VertexId>(tree.vertex_count(0))) {
        if (tree.rest(v)[0] < far - 1e-9) continue;
        sum -= displacement[v.index()][2];
        ++count;
    }
    return sum / count;
}

}  // namespace tetfront
