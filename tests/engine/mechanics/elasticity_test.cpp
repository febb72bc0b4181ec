#include "engine/mechanics/elasticity.hpp"

#include "engine/mechanics/cell_problem.hpp"

#include <Eigen/Eigenvalues>
#include <random>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

namespace tetfront {
namespace {

constexpr std::array all_problems = {CellProblem::average, CellProblem::mean_strain, CellProblem::isolated,
                                     CellProblem::uniform_stress};

TetTree small_box(int depth = 2) { return TetTree(box_mesh({0, 0, 0}, {2, 1, 1}, {2, 1, 1}), depth); }

/// Leaves of the given Young's moduli, in any order.
template <class Young>
LeafMaterials leaves_of(const TetTree& tree, const Young& young) {
    LeafMaterials leaves;
    for (TetId t : tree.level(tree.depth())) {
        Vec3 centre = Vec3::Zero();
        for (VertexId v : tree.corners(t)) centre += tree.rest(v) / 4;
        leaves.elasticity.push_back(isotropic(young(centre), 0.3));
        leaves.density.push_back(1000 + 100 * centre[0]);
        leaves.mass_damping.push_back(0);
        leaves.stiffness_damping.push_back(0);
    }
    return leaves;
}

double least_eigenvalue(const Mat6& m) {
    return Eigen::SelfAdjointEigenSolver<Mat6>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// Two layers across x in each coarse tet's width.
double layered(const Vec3& x) { return static_cast<int>(std::floor(x[0] * 4)) % 2 ? 1e6 : 1e4; }

TEST(Elasticity, UniformMaterialIsCopiedExactly) {
    const TetTree tree = small_box(3);
    const LeafMaterials leaves = leaves_of(tree, [](const Vec3&) { return 1e5; });
    for (CellProblem problem : {CellProblem::average, CellProblem::mean_strain, CellProblem::uniform_stress}) {
        const ElasticityMatrices m = estimate_elasticity(tree, leaves, problem);
        ASSERT_EQ(m.elasticity.size(), tree.tet_count());
        for (TetId t : ids<TetId>(tree.tet_count())) ASSERT_EQ(m.elasticity[t], leaves.elasticity[0]);
        EXPECT_TRUE(m.bracket.empty());
        EXPECT_TRUE(m.valid_range.empty());
    }
}

TEST(Elasticity, CellProblemIsExactForUniformMaterialWithoutTheShortCut) {
    const std::array<Vec3, 4> x = {{{0.1, 0, 0}, {1.3, 0.2, 0.1}, {0.3, 0.9, -0.2}, {0.2, 0.4, 1.1}}};
    std::array<Sym6, 8> children;
    children.fill(orthotropic({.young = {3e5, 1e5, 2e5}, .poisson = {0.2, 0.3, 0.25}, .shear = {4e4, 6e4, 5e4}}));
    for (CellProblem problem : {CellProblem::average, CellProblem::mean_strain, CellProblem::uniform_stress}) {
        const Mat6 c = solve_cell(problem, corner_gradients(x), children).matrix();
        EXPECT_LT((c - children[0].matrix()).norm(), 1e-12 * c.norm());
    }
    const Mat6 isolated = solve_cell(CellProblem::isolated, corner_gradients(x), children).matrix();
    EXPECT_GT((isolated - children[0].matrix()).norm(), 0.3 * children[0].matrix().norm());
}

TEST(Elasticity, ModesKeepTheMeanDeformationGradient) {
    for (int p = 0; p < 6; ++p) {
        Vec4 mean_stress_free = Vec4::Zero(), mean_strain = Vec4::Zero(), isolated = Vec4::Zero();
        for (std::size_t c = 0; c < 8; ++c) {
            mean_stress_free += uniform_stress_modes()[c].col(p);
            isolated += isolated_modes()[c].col(p);
            if (p < 3) mean_strain += mean_strain_modes()[c].col(p);
        }
        // Equal coefficients of the four gradients are the zero vector: their sum vanishes.
        EXPECT_LT((mean_stress_free.array() - mean_stress_free.mean()).matrix().norm(), 1e-12);
        EXPECT_LT((mean_strain.array() - mean_strain.mean()).matrix().norm(), 1e-12);
        EXPECT_GT((isolated.array() - isolated.mean()).matrix().norm(), 0.1);
    }
}

TEST(Elasticity, LayeredMaterialIsPositiveDefiniteAndOrderedBetweenTheBounds) {
    const TetTree tree = small_box(3);
    const LeafMaterials leaves = leaves_of(tree, layered);
    const auto average = estimate_elasticity(tree, leaves, CellProblem::average);
    const auto mean_strain = estimate_elasticity(tree, leaves, CellProblem::mean_strain);
    const auto lower = estimate_elasticity(tree, leaves, CellProblem::uniform_stress);
    double largest_gap = 0;
    for (int level = 0; level < tree.depth(); ++level) {
        for (TetId t : tree.level(level)) {
            const Mat6 a = average.elasticity[t].matrix(), m = mean_strain.elasticity[t].matrix(),
                       u = lower.elasticity[t].matrix();
            const double rounding = 1e-12 * a.norm();
            ASSERT_GT(least_eigenvalue(u), 0);
            ASSERT_GT(least_eigenvalue(m), 0);
            ASSERT_GE(least_eigenvalue(a - m), -rounding);
            ASSERT_GE(least_eigenvalue(m - u), -rounding);
            ASSERT_LE((mean_strain.bracket[t].matrix() - (a - u)).norm(), rounding);
            largest_gap = std::max(largest_gap, (a - m).norm() / a.norm());
        }
    }
    EXPECT_GT(largest_gap, 0.1);  // the material does vary inside of coarse tets
    for (TetId t : tree.level(tree.depth())) ASSERT_EQ(mean_strain.bracket[t], Sym6{});
}

TEST(Elasticity, MeanStrainIsTheLeastEnergyUnderTheConstraint) {
    // Against a dense solve with explicit Lagrange multipliers over all ten nodes, built from nothing but node
    // positions.
    const std::array<Vec3, 4> x = {{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1.2, 0.1}, {0.1, 0.3, 0.8}}};
    std::mt19937 random(7);
    std::uniform_real_distribution<double> exponent(4, 6);
    std::array<Sym6, 8> children;
    for (Sym6& c : children) c = isotropic(std::pow(10, exponent(random)), 0.35);

    std::array<Vec3, 10> node;
    std::copy(x.begin(), x.end(), node.begin());
    for (std::size_t e = 0; e < 6; ++e)
        node[4 + e] = (x[static_cast<std::size_t>(tet_edges[e][0])] + x[static_cast<std::size_t>(tet_edges[e][1])]) / 2;
    // Unknowns: 30 displacements, then multipliers: 9 of the mean gradient, 12 of the corners (mean_strain only).
    for (const CellProblem problem : {CellProblem::mean_strain, CellProblem::uniform_stress}) {
        const bool corners_fixed = problem == CellProblem::mean_strain;
        const int constraints = corners_fixed ? 9 + 12 : 9 + 3;
        Eigen::MatrixXd k = Eigen::MatrixXd::Zero(30 + constraints, 30 + constraints);
        Eigen::MatrixXd mean_gradient = Eigen::MatrixXd::Zero(9, 30);
        for (std::size_t c = 0; c < 8; ++c) {
            std::array<Vec3, 4> corners;
            for (std::size_t i = 0; i < 4; ++i) corners[i] = node[static_cast<std::size_t>(child_nodes[c][i])];
            const auto g = corner_gradients(corners);
            Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(9, 30);  // row 3 i + j: du_i / dx_j
            for (int n = 0; n < 4; ++n)
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        gradient(3 * i + j, 3 * child_nodes[c][static_cast<std::size_t>(n)] + i) = g(j, n);
            Eigen::MatrixXd strain(6, 30);
            for (std::size_t m = 0; m < 6; ++m) {
                const auto [i, j] = voigt_pairs[m];
                strain.row(static_cast<int>(m)) = gradient.row(3 * i + j);
                if (m >= 3) strain.row(static_cast<int>(m)) += gradient.row(3 * j + i);
            }
            k.topLeftCorner(30, 30) += strain.transpose() * children[c].matrix() * strain / 8;
            mean_gradient += gradient / 8;
        }
        k.block(30, 0, 9, 30) = mean_gradient;
        if (corners_fixed) {
            k.block(39, 0, 12, 12).setIdentity();
        } else {
            for (int n = 0; n < 10; ++n) k.block(39, 3 * n, 3, 3).setIdentity();  // no translation
        }
        k.block(0, 30, 30, constraints) = k.block(30, 0, constraints, 30).transpose();
        // The corner and the mean gradient constraints are partly dependent: a least-squares solve takes either form.
        Mat6 expected;
        Eigen::MatrixXd solutions(30, 6);
        for (int m = 0; m < 6; ++m) {
            const Mat3 e = strain_tensor(Vec6::Unit(m));
            Eigen::VectorXd rhs = Eigen::VectorXd::Zero(30 + constraints);
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) rhs[30 + 3 * i + j] = e(i, j);
            if (corners_fixed)
                for (std::size_t n = 0; n < 4; ++n) rhs.segment<3>(39 + 3 * static_cast<int>(n)) = e * node[n];
            solutions.col(m) = k.completeOrthogonalDecomposition().solve(rhs).head(30);
        }
        expected = solutions.transpose() * k.topLeftCorner(30, 30) * solutions;
        const Mat6 c = solve_cell(problem, corner_gradients(x), children).matrix();
        EXPECT_LT((c - expected).norm(), 1e-9 * expected.norm());
    }
}

TEST(Elasticity, BracketSeesMaterialThatTheChildrenNoLongerShow) {
    // The pattern repeats within every level-1 tet, so at level 0 all children carry similar matrices.
    const TetTree tree = small_box(3);
    const auto m = estimate_elasticity(tree, leaves_of(tree, layered), CellProblem::mean_strain);
    for (TetId root : tree.level(0)) {
        double children = 0;
        for (TetId child : tree.children(root)) children += m.bracket[child].matrix().trace() / 8;
        EXPECT_GE(m.bracket[root].matrix().trace(), children * (1 - 1e-12));
    }
}

TEST(Elasticity, StiffLeavesDoNotReachIntoUniformSubtrees) {
    const TetTree tree = small_box(2);
    const auto m = estimate_elasticity(tree, leaves_of(tree, [](const Vec3& x) { return x[0] < 1 ? 1e4 : 1e6; }),
                                       CellProblem::mean_strain);
    int uniform = 0;
    for (TetId t : ids<TetId>(tree.tet_count())) {
        if (m.elasticity[t] == isotropic(1e4, 0.3) || m.elasticity[t] == isotropic(1e6, 0.3)) {
            if (!m.bracket.empty()) EXPECT_EQ(m.bracket[t], Sym6{});
            ++uniform;
        }
    }
    EXPECT_EQ(uniform, static_cast<int>(tree.tet_count()));  // the jump runs between roots
}

TEST(Elasticity, RefusesContrastsThatDoublesCannotHold) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 1);
    const auto estimate = [&](double soft) {
        const StiffnessFunction f(layers(0, {0.5}), {{.young = constant(1)}, {.young = constant(soft)}});
        return estimate_elasticity(tree, integrate_leaves(tree, f), CellProblem::mean_strain);
    };
    EXPECT_NO_THROW(estimate(1e-11));
    EXPECT_THROW(estimate(1e-13), InputError);
}

TEST(Elasticity, ContrastOfAMillionAndNearlyIncompressibleStayPositiveDefinite) {
    const TetTree tree = small_box(2);
    std::mt19937 random(3);
    LeafMaterials leaves = leaves_of(tree, [](const Vec3&) { return 1.0; });
    for (Sym6& c : leaves.elasticity) c = isotropic(random() % 2 ? 1e3 : 1e9, 0.49);
    for (CellProblem problem : all_problems) {
        const auto m = estimate_elasticity(tree, leaves, problem);
        for (TetId t : ids<TetId>(tree.tet_count())) {
            const double least = least_eigenvalue(m.elasticity[t].matrix());
            ASSERT_TRUE(std::isfinite(least));
            ASSERT_GT(least, 0);
        }
    }
}

TEST(Elasticity, DensityOfACoarseTetIsTheMeanOfItsLeaves) {
    const TetTree tree = small_box(2);
    const LeafMaterials leaves = leaves_of(tree, layered);
    const PerTet<double> density = coarse_density(tree, leaves);
    for (int level = 0; level <= tree.depth(); ++level) {
        double mass = 0;
        for (TetId t : tree.level(level)) mass += density[t] * tree.volume(t);
        EXPECT_NEAR(mass, 2 * 1100, 1e-9 * mass);
    }
}

}  // namespace
}  // namespace tetfront
