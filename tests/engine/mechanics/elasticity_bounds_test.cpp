// The estimates against what is known of composites, and against static solves of the finest level.

#include "engine/mechanics/elasticity.hpp"
#include "tests/support/static_level.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

constexpr std::array all_problems = {CellProblem::average, CellProblem::mean_strain, CellProblem::uniform_stress};

double least_eigenvalue(const Mat6& m) {
    return Eigen::SelfAdjointEigenSolver<Mat6>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// Voigt's and Reuss's mean of the leaves below each root.
std::array<Mat6, 2> voigt_and_reuss(const TetTree& tree, const LeafMaterials& leaves, std::size_t root) {
    const std::size_t below = leaves.elasticity.size() / tree.root_count();
    Mat6 voigt = Mat6::Zero(), compliance = Mat6::Zero();
    for (std::size_t i = root * below; i < (root + 1) * below; ++i) {
        voigt += leaves.elasticity[i].matrix() / static_cast<double>(below);
        compliance += leaves.elasticity[i].matrix().inverse() / static_cast<double>(below);
    }
    return {voigt, compliance.inverse()};
}

TEST(ElasticityBounds, LaminatesLieBetweenReussAndVoigtInEveryDirection) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double contrast : {10.0, 100.0}) {
            const MaterialFunction soft{.young = constant(1)}, stiff{.young = constant(contrast)};
            const StiffnessFunction f(layers(axis, {0.25, 0.5, 0.75}), {soft, stiff, soft, stiff});
            const LeafMaterials leaves = integrate_leaves(tree, f);
            for (CellProblem problem : all_problems) {
                const auto m = estimate_elasticity(tree, leaves, problem);
                for (std::size_t root = 0; root < tree.root_count(); ++root) {
                    const auto [voigt, reuss] = voigt_and_reuss(tree, leaves, root);
                    const Mat6 c = m.elasticity[TetId(static_cast<std::int64_t>(root))].matrix();
                    EXPECT_GE(least_eigenvalue(voigt - c), -1e-10 * contrast);
                    EXPECT_GE(least_eigenvalue(c - reuss), -1e-10 * contrast);
                    if (problem == CellProblem::mean_strain) {
                        EXPECT_LT(c.trace(), 0.95 * voigt.trace());
                    }
                }
            }
        }
    }
}

TEST(ElasticityBounds, CheckerboardLiesAboveHashinShtrikmansLowerBoundAndNearTheUpper) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    auto checks = std::make_shared<VoxelImage>();
    checks->size = {4, 4, 4};
    for (int i = 0; i < 64; ++i) checks->data.push_back(static_cast<std::byte>((i + i / 4 + i / 16) % 2));
    checks->place(Vec3::Constant(0.125), Mat3::Identity() / 4);
    for (const auto& [contrast, low, high] : {std::array{10.0, 2.40, 4.20}, std::array{100.0, 2.95, 34.2}}) {
        const StiffnessFunction f(labels(checks, {{0, 0}, {1, 1}}),
                                  {{.young = constant(1)}, {.young = constant(contrast)}});
        const auto m = estimate_elasticity(tree, integrate_leaves(tree, f), CellProblem::mean_strain);
        Sym6 mean;
        for (TetId t : tree.level(0))
            for (std::size_t i = 0; i < 21; ++i) mean.upper[i] += m.elasticity[t].upper[i] / 6;
        EXPECT_GT(representative_young(mean), low);
        // Nine unknowns a parent do not relax the cell fully: 8 to 9 % above the bound of the true stiffness.
        EXPECT_LT(representative_young(mean), 1.1 * high);
    }
}

class Cantilever : public testing::Test {
 protected:
    /// Tip deflection of a level over that of the finest, linear tets.
    [[nodiscard]] double tip_ratio(const LeafMaterials& leaves, CellProblem problem, int level) const {
        const PerTet<double> density = coarse_density(tree_, leaves);
        const auto c = estimate_elasticity(tree_, leaves, problem).elasticity;
        return tip_deflection(tree_, solve_static_level(tree_, level, 1, c, density)) /
               tip_deflection(tree_, solve_static_level(tree_, 2, 1, c, density));
    }
    TetTree tree_{box_mesh({0, 0, 0}, {4, 1, 1}, {4, 1, 1}), 2};
};

TEST_F(Cantilever, IsolatedIsFarTooSoftAndTheOthersAreNot) {
    const LeafMaterials uniform = integrate_leaves(tree_, StiffnessFunction({.young = constant(1e7)}));
    for (CellProblem problem : all_problems) {
        EXPECT_NEAR(tip_ratio(uniform, problem, 1), 0.66, 0.01);
        EXPECT_NEAR(tip_ratio(uniform, problem, 0), 0.33, 0.01);
    }
    EXPECT_NEAR(tip_ratio(uniform, CellProblem::isolated, 1), 2.81, 0.1);
    EXPECT_NEAR(tip_ratio(uniform, CellProblem::isolated, 0), 6.68, 0.3);
}

TEST_F(Cantilever, MeanStrainIsNearerToTheFinestThanTheAverageForLayers) {
    const MaterialFunction soft{.young = constant(1e6)}, stiff{.young = constant(1e8)};
    const StiffnessFunction along(layers(2, {0.25, 0.5, 0.75}), {soft, stiff, soft, stiff});
    const LeafMaterials leaves = integrate_leaves(tree_, along);
    const double average = tip_ratio(leaves, CellProblem::average, 1),
                 mean = tip_ratio(leaves, CellProblem::mean_strain, 1);
    EXPECT_GT(mean, 1.1 * average);
    EXPECT_LT(mean, 1);
}

}  // namespace
}  // namespace tetfront
