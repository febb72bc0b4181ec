#pragma once
// Stiffness of one tet by quadrature, as textbooks have it: independent of the simulation's kernels on purpose, for tests
// and reports that hold those against it.
//
//     std::vector<VertexId> nodes = reference_nodes(tree, t, 2);
//     Eigen::MatrixXd k = reference_stiffness(tree, t, 2, c);     // 30 x 30, node by node

#include "engine/base/voigt.hpp"
#include "engine/mechanics/cell_problem.hpp"
#include "engine/tree/tet_tree.hpp"

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace tetfront {

/// Nodes of a tet: corners, then for order 2 the midpoints in the order of tet_edges.
inline std::vector<VertexId> reference_nodes(const TetTree& tree, TetId t, int order) {
    std::vector<VertexId> nodes(tree.corners(t).begin(), tree.corners(t).end());
    if (order == 2) nodes.insert(nodes.end(), tree.midpoints(t).begin(), tree.midpoints(t).end());
    return nodes;
}

/// c [Pa]. Exact for straight tets: one point for order 1, four for order 2.
inline Eigen::MatrixXd reference_stiffness(const TetTree& tree, TetId t, int order, const Mat6& c) {
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = tree.rest(tree.corners(t)[i]);
    const auto g = corner_gradients(x);
    const int nodes = order == 1 ? 4 : 10, points = order == 1 ? 1 : 4;
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * nodes, 3 * nodes);
    for (int point = 0; point < points; ++point) {
        Vec4 b = Vec4::Constant(order == 1 ? 0.25 : 0.13819660112501051518);
        if (order == 2) b[point] = 0.58541019662496845446;
        Eigen::MatrixXd strain = Eigen::MatrixXd::Zero(6, 3 * nodes);
        for (int i = 0; i < nodes; ++i) {
            Vec3 d;  // gradient of the shape function
            if (order == 1) {
                d = g.col(i);
            } else if (i < 4) {
                d = (4 * b[i] - 1) * g.col(i);
            } else {
                const auto [p, q] = tet_edges[static_cast<std::size_t>(i - 4)];
                d = 4 * (b[p] * g.col(q) + b[q] * g.col(p));
            }
            const int col = 3 * i;
            for (int r = 0; r < 3; ++r) strain(r, col + r) = d[r];
            strain(3, col + 1) = strain(4, col) = d[2];
            strain(3, col + 2) = strain(5, col) = d[1];
            strain(4, col + 2) = strain(5, col + 1) = d[0];
        }
        k += tree.volume(t) / points * strain.transpose() * c * strain;
    }
    return k;
}

}  // namespace tetfront
