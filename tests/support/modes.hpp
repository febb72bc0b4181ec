#pragma once
// Natural frequencies of one uniform quadratic level of a tree, for comparing mass matrices. Sparse, by subspace iteration;
// slow and independent of the simulation's kernels on purpose.
//
//     std::vector<double> f = natural_frequencies(tree, 0, Mass::consistent, true, 6, 1e6, 0.3, 1000);   // [Hz]

#include "engine/base/error.hpp"
#include "engine/base/voigt.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/tree/tet_tree.hpp"
#include "tests/support/reference_tet.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <numbers>
#include <vector>

namespace tetfront {

/// What a quadratic tet's mass matrix may be: the integral of the shape functions' products; its diagonal scaled to the tet's mass
/// (Hinton, Rock & Zienkiewicz 1976); or the row sums of its eight linear children. (Its own row sums are negative at corners.)
enum class Mass { consistent, hrz, children };

/// Entry (i, j) of the mass matrix of a quadratic tet over the tet's mass.
inline double quadratic_mass(Mass kind, std::size_t i, std::size_t j) {
    const double consistent = ElementOrder<2>::mass(static_cast<int>(i), static_cast<int>(j));
    if (kind == Mass::consistent) return consistent;
    if (i != j) return 0;
    if (kind == Mass::hrz) return consistent / (216.0 / 420);
    double sum = 0;
    for (const auto& child : child_nodes)
        for (const int n : child) sum += static_cast<std::size_t>(n) == i ? 1.0 / 32 : 0;
    return sum;
}

/// The lowest `count` natural frequencies [Hz] above the rigid motions of a uniform isotropic body, ascending. clamped: at x = 0.
inline std::vector<double> natural_frequencies(const TetTree& tree, int level, Mass kind, bool clamped, int count, double young,
                                               double poisson, double density) {
    std::vector<int> unknown(tree.vertex_count(), -1);
    int vertices = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count(level + 1)))
        if (!clamped || tree.rest(v)[0] > 1e-9) unknown[v.index()] = vertices++;
    const int n = 3 * vertices;
    const Mat6 c = isotropic_elasticity(young, poisson);
    std::vector<Eigen::Triplet<double>> stiffness, mass;
    for (TetId t : tree.level(level)) {
        const std::vector<VertexId> node = reference_nodes(tree, t, 2);
        const Eigen::MatrixXd k = reference_stiffness(tree, t, 2, c);
        for (std::size_t i = 0; i < 10; ++i) {
            for (std::size_t j = 0; j < 10; ++j) {
                const int row = unknown[node[i].index()], column = unknown[node[j].index()];
                if (row < 0 || column < 0) continue;
                const double m = tree.volume(t) * density * quadratic_mass(kind, i, j);
                for (int r = 0; r < 3; ++r) {
                    if (m != 0) mass.emplace_back(3 * row + r, 3 * column + r, m);
                    for (int s = 0; s < 3; ++s)
                        stiffness.emplace_back(3 * row + r, 3 * column + s, k(3 * static_cast<int>(i) + r, 3 * static_cast<int>(j) + s));
                }
            }
        }
    }
    Eigen::SparseMatrix<double> stiff(n, n), massive(n, n);
    stiff.setFromTriplets(stiffness.begin(), stiffness.end());
    massive.setFromTriplets(mass.begin(), mass.end());
    // Shifted by the square of a low frequency: positive definite also with rigid motions.
    const double shift = 1e-3 * young / density;
    const Eigen::SparseMatrix<double> shifted = stiff + shift * massive;
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(shifted);
    ENSURE(factor.info() == Eigen::Success, "stiffness matrix is not positive definite");
    const int rigid = clamped ? 0 : 6, wanted = count + rigid, block = std::min(n, 2 * wanted + 8);
    Eigen::MatrixXd basis = Eigen::MatrixXd::NullaryExpr(n, block, [](Eigen::Index r, Eigen::Index s) {
        return std::sin(1.7 * static_cast<double>(r * (s + 1)) + static_cast<double>(s));
    });
    Eigen::VectorXd values;
    for (int iteration = 0; iteration < 25; ++iteration) {
        basis = factor.solve(massive * basis).eval();
        const Eigen::MatrixXd a = basis.transpose() * (shifted * basis), b = basis.transpose() * (massive * basis);
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> small(a, b);
        ENSURE(small.info() == Eigen::Success, "subspace iteration failed in iteration ", iteration);
        basis = (basis * small.eigenvectors()).eval();
        values = small.eigenvalues();
    }
    std::vector<double> frequencies;
    for (int i = rigid; i < wanted; ++i) frequencies.push_back(std::sqrt(std::max(values[i] - shift, 0.0)) / (2 * std::numbers::pi));
    return frequencies;
}

}  // namespace tetfront
