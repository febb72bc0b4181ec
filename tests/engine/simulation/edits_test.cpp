// Forces, pins, stiffness, damping, the order and the levels changed while a simulation runs.
#include "engine/simulation/simulation.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/simulation/pulls.hpp"
#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

using testing::box_model;
using testing::cantilever_model;

/// Where the middle of a surface triangle is now.
Vec3 centre(Simulation& simulation, std::uint32_t triangle) {
    const auto frame = simulation.frame();
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t v : frame->model->triangles[triangle])
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(frame->surface[v][static_cast<std::size_t>(c)]) / 3;
    return sum;
}

/// The triangle whose centre is farthest along +x.
std::uint32_t tip_of(Simulation& simulation) {
    const std::size_t count = simulation.frame()->model->triangles.size();
    std::uint32_t best = 0;
    for (std::uint32_t t = 0; t < count; ++t)
        if (centre(simulation, t).x() > centre(simulation, best).x()) best = t;
    return best;
}

void step(Simulation& simulation, int count) {
    for (int i = 0; i < count; ++i) simulation.step();
}

/// Of the tip under little gravity, at order 2 on a fixed front.
double sag(const Edits& edits, const char* level = "0") {
    Simulation simulation(cantilever_model({{"/gravity", "[0, 0, -0.05]"}, {"/front/min_level", level}, {"/front/max_level", level}}));
    const std::uint32_t tip = tip_of(simulation);
    const double rest = centre(simulation, tip).z();
    simulation.set_edits(edits);
    EXPECT_TRUE(simulation.settle().converged);
    return rest - centre(simulation, tip).z();
}

TEST(Edits, FramesShowTheForcesThatAct) {
    Simulation simulation(cantilever_model(
        {{"/forces", R"([{"region": {"half_space": {"point": [1.999, 0, 0], "normal": [-1, 0, 0]}}, "force": [0, 0, -5], "end": 0.01},
                         {"region": {"half_space": {"point": [1.999, 0, 0], "normal": [-1, 0, 0]}}, "force": [3, 0, 0]},
                         {"region": {"half_space": {"point": [1.999, 0, 0], "normal": [-1, 0, 0]}}, "force": [0, 7, 0], "start": 9}])"}}));
    const auto at_rest = simulation.frame()->forces;
    ASSERT_EQ(at_rest.size(), 2U) << "the third comes later";
    EXPECT_NEAR(at_rest[0].value[2], -5, 1e-5) << "of all points together";
    EXPECT_NEAR(at_rest[1].value[0], 3, 1e-5);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(at_rest[0].at[c], c == 0 ? 2 : 0.5, 1e-5) << "in the middle of its region";
    Edits edits;
    edits.forces[4] = {{tip_of(simulation), Vec3::Constant(1.0 / 3)}, {0, 0, 10}};
    simulation.set_edits(edits);
    simulation.step();
    const auto later = simulation.frame()->forces;
    ASSERT_EQ(later.size(), 2U) << "the first is over";
    EXPECT_NEAR(later[0].value[0], 3, 1e-5);
    EXPECT_EQ(later[1].value[2], 10);
    EXPECT_LT(later[0].at[2], 0.5) << "it sinks with the object";
}

TEST(Edits, TwiceTheStiffnessHalvesASmallDeflection) {
    Edits stiffer;
    stiffer.stiffness_scale = 2;
    const double once = sag({}), twice = sag(stiffer);
    EXPECT_GT(once, 1e-4);
    EXPECT_NEAR(once / twice, 2, 0.02);
}

/// Times the stiffness of what is near the first corner that is clamped.
Edits near_the_clamp(double scale, double radius) {
    const auto model = cantilever_model();
    const auto& triangles = model->frame_model->triangles;
    Edits edits;
    for (std::uint32_t t = 0; t < triangles.size() && edits.stiffness.empty(); ++t)
        for (int c = 0; c < 3; ++c)
            if (const SurfacePoint corner{t, Vec3::Unit(c)}; rest_position(*model, corner).norm() < 1e-9) edits.stiffness = {{corner, radius, scale}};
    EXPECT_EQ(edits.stiffness.size(), 1U);
    return edits;
}

TEST(Edits, APartThatIsEverythingIsTheWhole) {
    Edits whole;
    whole.stiffness_scale = 3;
    EXPECT_EQ(sag(near_the_clamp(3, 10)), sag(whole));
    Edits both = near_the_clamp(0.01, 10);
    both.stiffness.push_back({both.stiffness[0].centre, 9, 2});
    both.stiffness_scale = 1.5;
    EXPECT_EQ(sag(both), sag(whole)) << "the last word counts, times the whole's";
    EXPECT_EQ(sag(near_the_clamp(3, 1e-3)), sag({})) << "no leaf is as near as that";
}

TEST(Edits, ACoarseFrontKnowsAPartThatOnlyItsLeavesResolve) {
    // A quarter of the root tets at the clamp: their matrices are estimated from leaves of both kinds.
    const double coarse = sag({}), fine = sag({}, "1");
    const double coarse_part = sag(near_the_clamp(20, 0.45)), fine_part = sag(near_the_clamp(20, 0.45), "1");
    EXPECT_LT(fine_part, 0.95 * fine);
    EXPECT_NEAR(coarse_part / coarse, fine_part / fine, 0.2 * (1 - fine_part / fine));
}

TEST(Edits, TakenBackLeaveTheSameMotionAsNeverMade) {
    Simulation touched(cantilever_model()), untouched(cantilever_model());
    Edits edits;
    edits.stiffness_scale = 3, edits.stiffness_damping = 0.1;
    edits.stiffness = {{{0, Vec3::Constant(1.0 / 3)}, 0.5, 7}};
    edits.pins = {{false, {0, Vec3::Constant(1.0 / 3)}, 10}};
    edits.forces[1] = {{5, Vec3::Constant(1.0 / 3)}, {0, 0, 10}};
    touched.set_edits(edits);
    EXPECT_EQ(touched.edits(), edits);
    touched.set_edits({});
    touched.reset();
    step(touched, 20), step(untouched, 20);
    EXPECT_EQ(touched.hash(), untouched.hash());
}

TEST(Edits, AForceAcceleratesAFreeBodyByNewtonsLaw) {
    Simulation simulation(box_model({{"/solver/cg_tolerance", "1e-8"}}));
    Edits edits;
    const Vec3 force(0, 0, 40);
    edits.forces[3] = {{tip_of(simulation), Vec3::Constant(1.0 / 3)}, force};
    simulation.set_edits(edits);
    step(simulation, 30);
    EXPECT_LT((simulation.momentum().linear - 0.5 * force).norm(), 1e-3 * 20);
    edits.forces.clear();
    simulation.set_edits(edits);
    const Vec3 before = simulation.momentum().linear;
    step(simulation, 10);
    EXPECT_LT((simulation.momentum().linear - before).norm(), 1e-3 * before.norm());
}

TEST(Edits, APinHoldsWhereTheObjectIsNow) {
    Simulation simulation(cantilever_model());
    const std::uint32_t tip = tip_of(simulation);
    step(simulation, 10);
    const Vec3 there = centre(simulation, tip);
    Edits edits;
    edits.pins = {{true, {tip, Vec3::Constant(1.0 / 3)}, 1}};  // larger than a tet
    simulation.set_edits(edits);
    step(simulation, 30);
    EXPECT_LT((centre(simulation, tip) - there).norm(), 1e-6);
    edits.pins.push_back({false, {tip, Vec3::Constant(1.0 / 3)}, 1});
    simulation.set_edits(edits);
    step(simulation, 30);
    EXPECT_GT((centre(simulation, tip) - there).norm(), 1e-3);
    EXPECT_NO_THROW(simulation.front().validate());
}

TEST(Edits, ASmallPinSplitsTheTetsThatMissIt) {
    // The middle of the top, far from every coarse vertex.
    Simulation simulation(cantilever_model({{"/mesh/box/cells", "[2, 1, 1]"}, {"/front/tolerance", "1"}}));
    const std::uint32_t tip = tip_of(simulation);
    Edits edits;
    edits.pins = {{true, {tip, Vec3(1, 0, 0)}, 0.01}};
    simulation.set_edits(edits);
    const auto frame = simulation.frame();
    const auto corner = frame->surface[frame->model->triangles[tip][0]];
    step(simulation, 20);
    const auto after = simulation.frame()->surface[frame->model->triangles[tip][0]];
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c], corner[c], 1e-6);
}

TEST(Edits, UnpinningEverythingLetsTheObjectFall) {
    Simulation simulation(cantilever_model());
    Edits edits;
    edits.pins = {{false, {0, Vec3::Constant(1.0 / 3)}, 10}};
    simulation.set_edits(edits);
    step(simulation, 30);
    const double fall = simulation.momentum().linear.z() / simulation.model().mass;
    EXPECT_NEAR(fall, -9.81 * 0.5, 0.05);
}

TEST(Edits, TheOrderChangesWhileShapeAndMotionStay) {
    for (const int first : {1, 2}) {
        Simulation simulation(cantilever_model({{"/front/order", std::to_string(first)}}));
        const std::uint32_t tip = tip_of(simulation);
        step(simulation, 12);
        const Vec3 place = centre(simulation, tip), momentum = simulation.momentum().linear;
        const auto epoch = simulation.frame()->topology->epoch;
        simulation.set_order(3 - first);
        EXPECT_EQ(simulation.front().order(), 3 - first);
        EXPECT_NO_THROW(simulation.front().validate());
        EXPECT_LT((centre(simulation, tip) - place).norm(), 0.02);
        EXPECT_LT((simulation.momentum().linear - momentum).norm(), 0.05 * momentum.norm());
        EXPECT_EQ(simulation.frame()->topology->epoch, epoch + 1) << "viewers see another topology";
        step(simulation, 12);
        EXPECT_TRUE(std::isfinite(simulation.energy().elastic));
        EXPECT_NO_THROW(simulation.front().validate());
    }
}

TEST(Edits, TheLevelsChangeWhileShapeAndMotionStay) {
    for (const int order : {1, 2}) {
        Simulation simulation(cantilever_model({{"/levels", "2"}, {"/front/order", std::to_string(order)}, {"/front/tolerance", "0.0005"}}));
        const int deepest = order == 1 ? 2 : 1;
        const std::uint32_t tip = tip_of(simulation);
        const auto levels = [&] {
            std::set<int> seen;
            for (const TetId t : simulation.front().active()) seen.insert(simulation.model().tree.level_of(t));
            return seen;
        };
        step(simulation, 12);
        EXPECT_TRUE(levels().contains(deepest)) << "the tolerance is too large for this test";
        const auto stays = [&](int low, int high, const std::set<int>& expected) {
            const Vec3 place = centre(simulation, tip), momentum = simulation.momentum().linear;
            simulation.set_levels(low, high);
            EXPECT_NO_THROW(simulation.front().validate());
            EXPECT_EQ(levels(), expected) << low << ".." << high;
            EXPECT_LT((centre(simulation, tip) - place).norm(), 0.03);
            EXPECT_LT((simulation.momentum().linear - momentum).norm(), 0.05 * momentum.norm());
        };
        stays(0, 0, {0});
        step(simulation, 12);
        EXPECT_EQ(levels(), std::set<int>{0}) << "no finer than was said";
        stays(9, 9, {deepest});
        simulation.set_tolerance(1);
        step(simulation, 12);
        EXPECT_EQ(levels(), std::set<int>{deepest}) << "no coarser than was said";
        simulation.reset();
        EXPECT_EQ(levels(), std::set<int>{deepest});
        step(simulation, 12);
        const auto epoch = simulation.frame()->topology->epoch;
        simulation.set_levels(deepest, deepest);
        EXPECT_EQ(simulation.frame()->topology->epoch, epoch) << "the same levels in other words";
        simulation.set_levels(0, 99);
        step(simulation, 60);
        EXPECT_TRUE(levels().contains(0)) << "as coarse as the tolerance lets it be again";
        EXPECT_TRUE(std::isfinite(simulation.energy().elastic));
    }
}

TEST(Edits, RefusesWhatIsOutOfRangeAndChangesNothing) {
    Simulation simulation(cantilever_model());
    const auto refused = [&](auto change) {
        Edits edits;
        change(edits);
        EXPECT_THROW(simulation.set_edits(edits), InputError);
        EXPECT_EQ(simulation.edits(), Edits{});
    };
    refused([](Edits& e) { e.stiffness_scale = 0; });
    refused([](Edits& e) { e.stiffness_scale = NAN; });
    refused([](Edits& e) { e.stiffness = {{{}, 1, 0}}; });
    refused([](Edits& e) { e.stiffness = {{{}, -1, 1}}; });
    refused([](Edits& e) { e.stiffness = {{{1U << 30, Vec3::Unit(0)}, 1, 1}}; });
    refused([](Edits& e) { e.mass_damping = -1; });
    refused([](Edits& e) { e.stiffness_damping = 1e308; });
    refused([](Edits& e) { e.forces[0].at.triangle = 1u << 30; });
    refused([](Edits& e) { e.forces[0].value = {0, NAN, 0}; });
    refused([](Edits& e) { e.pins = {{true, {0, {2, 0, -1}}, 1}}; });
    refused([](Edits& e) { e.pins = {{true, {}, -1}}; });
    EXPECT_THROW(simulation.set_order(3), InputError);
    EXPECT_THROW(simulation.set_levels(-1, 1), InputError);
    EXPECT_THROW(simulation.set_levels(2, 1), InputError);
}

}  // namespace
}  // namespace tetfront
