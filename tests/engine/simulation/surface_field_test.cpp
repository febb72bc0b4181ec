#include "engine/simulation/surface_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "engine/simulation/simulation.hpp"
#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

using testing::box_model;
using testing::cantilever_model;

class FieldOfOrder : public ::testing::TestWithParam<int> {
 protected:
    [[nodiscard]] Override order() const { return {"/front/order", std::to_string(GetParam())}; }
};

/// A stiff beam of 4x1x1 m at rest under its weight.
std::unique_ptr<Simulation> still_beam(const Override& order) {
    auto simulation = std::make_unique<Simulation>(
        cantilever_model({order, {"/mesh/box/high", "[4, 1, 1]"}, {"/mesh/box/cells", "[8, 2, 2]"}, {"/material", R"({"density": 1000, "poisson": 0.3, "young": 5e7})"},
                          {"/damping", R"({"mass": 12})"}, {"/front/min_level", "1"}, {"/levels", "2"}}));
    for (int i = 0; i < 80; ++i) simulation->step();  // it swings at 14 rad/s and loses e^-8
    return simulation;
}

TEST_P(FieldOfOrder, CostsNothingUnlessAsked) {
    Simulation simulation(box_model({order()}));
    EXPECT_EQ(simulation.frame()->field, Field::none);
    EXPECT_TRUE(simulation.frame()->field_values.empty());
}

TEST_P(FieldOfOrder, RestHasNothingToShow) {
    Simulation simulation(box_model({order()}));
    for (const Field field : {Field::displacement, Field::strain, Field::stress, Field::error}) {
        const auto frame = simulation.frame(0, field);
        ASSERT_EQ(frame->field_values.size(), frame->surface.size());
        EXPECT_EQ(frame->field, field);
        for (const float value : frame->field_values) EXPECT_NEAR(value, 0, 1e-4);
    }
}

TEST_P(FieldOfOrder, DisplacementIsTheWayFromRest) {
    const auto simulation = still_beam(order());
    const auto frame = simulation->frame(0, Field::displacement);
    const auto& rest = simulation->model().surface.mesh.positions;
    for (std::size_t i = 0; i < frame->surface.size(); ++i) {
        const Vec3 now(frame->surface[i][0], frame->surface[i][1], frame->surface[i][2]);
        EXPECT_NEAR(frame->field_values[i], (now - rest[i]).norm(), 1e-6);
    }
}

TEST_P(FieldOfOrder, StressOfABeamUnderItsWeight) {
    const auto simulation = still_beam(order());
    const auto frame = simulation->frame(0, Field::stress);
    const auto& rest = simulation->model().surface.mesh.positions;
    // Euler and Bernoulli: M c / I with M = rho g A (L - x)^2 / 2, on the upper and lower face.
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        const Vec3& p = rest[i];
        if (std::abs(p.x() - 2) > 0.3 || std::min(p.z(), 1 - p.z()) > 1e-6 || p.y() < 0.3 || p.y() > 0.7) continue;
        const double expected = 1000 * 9.81 * std::pow(4 - p.x(), 2) / 2 * 0.5 * 12;
        sum += static_cast<double>(frame->field_values[i]) / expected;
        ++count;
    }
    ASSERT_GT(count, 3);
    EXPECT_NEAR(sum / count, 1, GetParam() == 1 ? 0.35 : 0.12) << "linear tets are too stiff in bending";
}

TEST_P(FieldOfOrder, StressIsThreeShearModuliTimesEquivalentStrain) {
    const auto simulation = still_beam(order());
    const auto stress = simulation->frame(0, Field::stress), strain = simulation->frame(0, Field::strain);
    const double shear = 5e7 / (2 * (1 + 0.3));
    for (std::size_t i = 0; i < stress->surface.size(); ++i)
        EXPECT_NEAR(stress->field_values[i], 3 * shear * static_cast<double>(strain->field_values[i]),
                    1e-4 * static_cast<double>(stress->field_values[i]) + 1);
}

TEST_P(FieldOfOrder, ErrorIsAPartOfTheEstimate) {
    Simulation simulation(cantilever_model({order(), {"/material/young", "1e6"}}));
    for (int i = 0; i < 20; ++i) simulation.step();
    const auto frame = simulation.frame(0, Field::error);
    ASSERT_GT(frame->status.estimate, 0);
    const float most = *std::ranges::max_element(frame->field_values);
    EXPECT_GT(most, 0);
    EXPECT_LE(most, frame->status.estimate);
}

TEST(FieldHigh, LeavesOutTheHighestFew) {
    std::vector<float> values;
    for (int i = 0; i < 1000; ++i) values.push_back(static_cast<float>(i));
    EXPECT_NEAR(field_high(values), 980, 2);
    values.push_back(std::numeric_limits<float>::infinity());
    values.push_back(std::numeric_limits<float>::quiet_NaN());
    EXPECT_NEAR(field_high(values), 980, 2);
    EXPECT_EQ(field_high({}), 0);
    EXPECT_EQ(field_high({7}), 7);
}

TEST_P(FieldOfOrder, TimelineReleasesPins) {
    Simulation simulation(box_model({order(), {"/gravity", "[0, 0, -10]"},
                                     {"/pins", R"([{"half_space": {"point": [9, 0, 0], "normal": [1, 0, 0]}}])"},
                                     {"/timeline", R"([{"time": 0.1, "release": 0}])"}}));
    const auto mass = simulation.model().mass;
    for (int i = 0; i < 6; ++i) simulation.step();
    EXPECT_EQ(simulation.momentum().linear.norm(), 0) << "pinned whole";
    for (int i = 0; i < 12; ++i) simulation.step();
    EXPECT_NEAR(simulation.momentum().linear.z() / mass, -10 * 12 / 60.0, 1e-4) << "then it falls";
    const auto end = simulation.hash();
    simulation.reset();
    for (int i = 0; i < 6; ++i) simulation.step();
    EXPECT_EQ(simulation.momentum().linear.norm(), 0) << "pinned again";
    for (int i = 0; i < 12; ++i) simulation.step();
    EXPECT_EQ(simulation.hash(), end);
}

TEST_P(FieldOfOrder, TimelineChangesGravity) {
    Simulation simulation(box_model({order(), {"/gravity", "[0, 0, -6]"}, {"/pins", "[]"},
                                     {"/timeline", R"([{"time": 0.05, "gravity": [0, 0, 0]}, {"time": 0.1, "gravity": [12, 0, 0]}])"}}));
    const auto mass = simulation.model().mass;
    for (int run = 0; run < 2; ++run) {
        for (int i = 0; i < 9; ++i) simulation.step();
        EXPECT_NEAR((simulation.momentum().linear / mass - Vec3(12 * 3 / 60.0, 0, -6 * 3 / 60.0)).norm(), 0, 1e-4) << run;
        simulation.reset();
    }
}

INSTANTIATE_TEST_SUITE_P(Orders, FieldOfOrder, ::testing::Values(1, 2));

}  // namespace
}  // namespace tetfront
