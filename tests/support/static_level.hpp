#pragma once
// Linear static solve on one uniform level of a tree, for tests and reports: clamped where x = 0, by a sparse direct
// factorisation. Slow and independent of the simulation's kernels on purpose.
//
//     std::vector<Vec3> u = solve_static_level(tree, 1, 2, matrices.elasticity, density);   // under gravity along -z
//     u = solve_static_level(tree, 1, 2, elasticity, end_load(tree, 1, 2, Vec3(0, 0, -1)));  // level 1, quadratic tets

#include "engine/base/error.hpp"
#include "engine/base/pooled.hpp"
#include "engine/base/voigt.hpp"
#include "engine/tree/tet_tree.hpp"
#include "tests/support/reference_tet.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <vector>

namespace tetfront {

/// Consistent nodal forces [N] on each of the tree's vertices: the weight of all tets.
inline std::vector<Vec3> weight_load(const TetTree& tree, int level, int order, const PerTet<double>& density) {
    std::vector<Vec3> load(tree.vertex_count(), Vec3::Zero());
    for (TetId t : tree.level(level)) {
        const std::vector<VertexId> node = reference_nodes(tree, t, order);
        for (std::size_t i = 0; i < node.size(); ++i) {
            // Integral of the shape function: order 2 corners -1/20, midpoints 1/5.
            const double share = order == 1 ? 0.25 : i < 4 ? -0.05 : 0.2;
            load[node[i].index()][2] -= share * tree.volume(t) * density[t] * 9.81;
        }
    }
    return load;
}

/// Consistent nodal forces [N] of a force spread evenly over the end face: where x is largest.
inline std::vector<Vec3> end_load(const TetTree& tree, int level, int order, const Vec3& force) {
    double far = 0, area = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count(0))) far = std::max(far, tree.rest(v)[0]);
    std::vector<Vec3> load(tree.vertex_count(), Vec3::Zero());
    const auto at_end = [&](VertexId v) { return tree.rest(v)[0] > far - 1e-9 * far; };
    for (TetId t : tree.level(level)) {
        const std::vector<VertexId> node = reference_nodes(tree, t, order);
        std::vector<VertexId> face;
        for (std::size_t i = 0; i < 4; ++i)
            if (at_end(node[i])) face.push_back(node[i]);
        if (face.size() != 3) continue;
        const double part = (tree.rest(face[1]) - tree.rest(face[0])).cross(tree.rest(face[2]) - tree.rest(face[0])).norm() / 2;
        area += part;
        // Integral of the face's shape functions: a third of it each at the corners, for order 2 at the midpoints.
        if (order == 2) {
            face.clear();
            for (std::size_t i = 4; i < 10; ++i)
                if (at_end(node[i])) face.push_back(node[i]);
        }
        for (VertexId v : face) load[v.index()] += part / 3 * force;
    }
    for (Vec3& f : load) f /= area;
    return load;
}

/// order 2 takes the vertices of level + 1 as nodes: level < depth. load: [V] nodal forces [N]. Returns the displacement [m] of
/// each of the tree's vertices, zero where it is no node.
inline std::vector<Vec3> solve_static_level(const TetTree& tree, int level, int order, const PooledPerTet<Sym6>& elasticity,
                                            const std::vector<Vec3>& nodal_load) {
    const std::size_t nodes = order == 1 ? 4 : 10;
    std::vector<int> unknown(tree.vertex_count(), -1);
    int count = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count(order == 1 ? level : level + 1)))
        if (tree.rest(v)[0] > 1e-9) unknown[v.index()] = count++;

    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * count);
    for (TetId t : tree.level(level)) {
        const std::vector<VertexId> node = reference_nodes(tree, t, order);
        const Eigen::MatrixXd k = reference_stiffness(tree, t, order, elasticity[t].matrix());
        for (std::size_t i = 0; i < nodes; ++i) {
            const int row = unknown[node[i].index()];
            if (row < 0) continue;
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
    for (std::size_t v = 0; v < unknown.size(); ++v)
        if (unknown[v] >= 0) load.segment<3>(3 * unknown[v]) = nodal_load[v];
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

/// The same under gravity along -z.
inline std::vector<Vec3> solve_static_level(const TetTree& tree, int level, int order, const PooledPerTet<Sym6>& elasticity,
                                            const PerTet<double>& density) {
    return solve_static_level(tree, level, order, elasticity, weight_load(tree, level, order, density));
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
