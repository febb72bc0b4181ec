// Against theory and publications: values and rates of convergence. The report (tests/benchmarks/verification_report.cpp) has the
// same problems on finer meshes.
#include "tests/support/verification.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace tetfront::testing {
namespace {

TEST(BeamTheory, EllipticIntegralsGiveThePublishedElastica) {
    // Bisshopp & Drucker 1945, as tabulated in the literature.
    const std::array<std::array<double, 2>, 6> published = {
        {{1, 0.30172}, {2, 0.49346}, {3, 0.60325}, {4, 0.66996}, {5, 0.71379}, {10, 0.81061}}};
    for (const auto& [load, deflection] : published) EXPECT_NEAR(elastica_deflection(load), deflection, 6e-6) << load;
    EXPECT_NEAR(elastica_deflection(1e-4) / 1e-4, 1.0 / 3, 1e-5);  // small loads: linear theory
}

TEST(BeamTheory, SlenderFreeBeamsHaveEulersFrequencies) {
    const SquareBeam beam{1000, 1, 1e9};
    const auto f = free_beam_frequencies(beam, 1000, 2);
    const double unit = std::sqrt(beam.young * beam.second_moment() / (1000 * beam.area())) / (beam.length * beam.length) / (2 * std::numbers::pi);
    EXPECT_NEAR(f[0] / unit, 22.3733, 1e-3);
    EXPECT_NEAR(f[1] / unit, 61.6728, 1e-2);
}

TEST(Verification, CantileverTipConvergesToTimoshenko) {
    const double theory = timoshenko_tip_of_end_load(verification_beam, 1);
    std::array<double, 3> linear{}, quadratic{};
    for (int level = 0; level < 3; ++level) {
        linear[static_cast<std::size_t>(level)] = cantilever_tip(1, level + 1) / theory;
        quadratic[static_cast<std::size_t>(level)] = level < 2 ? cantilever_tip(2, level) / theory : 0;
    }
    // On its way to second order from below: 1.36, then 1.77.
    const double first = std::log2((1 - linear[0]) / (1 - linear[1])), second = std::log2((1 - linear[1]) / (1 - linear[2]));
    EXPECT_GT(first, 1.2);
    EXPECT_GT(second, 1.6);
    EXPECT_LT(linear[2], 1);
    EXPECT_NEAR(quadratic[0], 1, 0.03);
    EXPECT_NEAR(quadratic[1], 1, 0.004);
    EXPECT_GT(std::abs(quadratic[0] - 1) / std::abs(quadratic[1] - 1), 4) << "at least second order";
}

TEST(Verification, TwistedBeamOfMacNealAndHarder) {
    const auto coarse = twisted_beam_tip(2, 1), fine = twisted_beam_tip(2, 2);
    EXPECT_NEAR(fine[0] / TwistedBeam::in_plane, 1, 0.01);
    EXPECT_NEAR(fine[1] / TwistedBeam::out_of_plane, 1, 0.01);
    EXPECT_LT(std::abs(fine[0] / TwistedBeam::in_plane - 1), std::abs(coarse[0] / TwistedBeam::in_plane - 1));
}

TEST(Verification, LargeDeflectionFollowsTheElastica) {
    const auto tips = elastica_tips({1, 2}, 20, 0);
    EXPECT_NEAR(tips[0], elastica_deflection(1), 0.002);
    EXPECT_NEAR(tips[1], elastica_deflection(2), 0.003);
}

TEST(Verification, RotationsAreExact) {
    for (const int order : {1, 2}) {
        const Rotated worst = rotated_box(order);
        EXPECT_LT(worst.energy, 1e-24);
        EXPECT_LT(worst.force, 1e-12);
    }
}

TEST(Verification, MidpointKeepsWhatBackwardEulerLoses) {
    const auto midpoint = swinging_energy("midpoint", 1.0 / 60, 120), euler = swinging_energy("backward_euler", 1.0 / 60, 120);
    EXPECT_LT(std::abs(midpoint.back() - 1), 0.01);
    EXPECT_LT(euler.back(), 0.95);
    EXPECT_LE(*std::ranges::max_element(euler), 1);
    // Half the step loses less; not yet half as much, because the higher modes are damped away at either step.
    const double half = swinging_energy("backward_euler", 1.0 / 120, 240).back();
    EXPECT_GT(std::log(euler.back()) / std::log(half), 1.4);
    const Spin spin = spinning_box("midpoint", 60);
    EXPECT_LT(spin.angular_momentum, 1e-7);
    EXPECT_LT(spin.energy, 0.01);
    EXPECT_LT(free_fall_error("midpoint"), 1e-6);
}

}  // namespace
}  // namespace tetfront::testing
