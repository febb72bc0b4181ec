// Which mass matrix quadratic tets should have: the consistent one, held against two positive diagonals on the natural frequencies
// of a beam.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/modes.hpp"

namespace tetfront {
namespace {

constexpr std::array kinds = {Mass::consistent, Mass::hrz, Mass::children};

TEST(QuadraticMass, EveryKindHasTheTetsMassAndIsPositive) {
    for (const Mass kind : kinds) {
        Eigen::Matrix<double, 10, 10> m;
        for (int i = 0; i < 10; ++i)
            for (int j = 0; j < 10; ++j) m(i, j) = quadratic_mass(kind, static_cast<std::size_t>(i), static_cast<std::size_t>(j));
        EXPECT_NEAR(m.sum(), 1, 1e-14);
        EXPECT_GT((Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues().minCoeff()), 1e-3);
    }
}

TEST(QuadraticMass, TheConsistentOneIsBestOnFreeAndClampedBeams) {
    // Mean error of the six lowest frequencies. (On 24 tets a diagonal wins for the clamped beam: its mass errs downwards, the
    // stiffness upwards, and the two cancel.)
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {4, 1, 1}), 3);
    for (const bool clamped : {true, false}) {
        constexpr int modes = 6;
        const auto truth = natural_frequencies(tree, 2, Mass::consistent, clamped, modes, 1e6, 0.3, 1000);
        std::array<double, 3> mean{};
        for (std::size_t k = 0; k < kinds.size(); ++k) {
            const auto f = natural_frequencies(tree, 1, kinds[k], clamped, modes, 1e6, 0.3, 1000);
            for (std::size_t i = 0; i < f.size(); ++i) mean[k] += std::abs(f[i] / truth[i] - 1) / modes;
        }
        EXPECT_LT(mean[0], 0.01);
        EXPECT_LT(mean[0], mean[1]) << "HRZ, clamped " << clamped;
        EXPECT_LT(mean[0], mean[2]) << "children, clamped " << clamped;
    }
}

}  // namespace
}  // namespace tetfront
