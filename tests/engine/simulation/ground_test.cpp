// The ground: what falls on it stays on it, slides as Coulomb says, and nothing breaks.

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

using testing::box_model;

struct Setting {
    int order;
    const char* scheme;
};
class Ground : public ::testing::TestWithParam<Setting> {
 protected:
    /// 2 x 1 x 1 m, 2000 kg, its lower face at z = 0.
    [[nodiscard]] Simulation box(std::vector<Override> overrides) const {
        overrides.insert(overrides.begin(), {{"/mesh/box/cells", "[2, 1, 1]"},
                                             {"/levels", "1"},
                                             {"/front/order", std::to_string(GetParam().order)},
                                             {"/solver/scheme", "\"" + std::string(GetParam().scheme) + "\""},
                                             {"/ground", R"({"height": 0, "friction": 0.5})"},
                                             {"/damping", R"({"stiffness": 0.01})"},
                                             {"/gravity", "[0, 0, -9.81]"}});
        return Simulation(box_model(overrides));
    }
    static void steps(Simulation& simulation, int count) {
        for (int i = 0; i < count; ++i) ASSERT_FALSE(simulation.step().rejected) << "step " << i;
    }
    /// Of all vertices [m].
    static double lowest(const Simulation& simulation) {
        double low = INFINITY;
        const PerVertex<Vec3> x = simulation.all_positions();
        for (VertexId v : ids<VertexId>(x.size())) low = std::isfinite(x[v][2]) ? std::min(low, x[v][2]) : std::nan("");
        return low;
    }
    static Vec3 velocity(const Simulation& simulation) { return simulation.momentum().linear / simulation.model().mass; }
    static Vec3 centre(const Simulation& simulation) {
        const PerVertex<Vec3> x = simulation.all_positions();
        Vec3 sum = Vec3::Zero();
        for (VertexId v : ids<VertexId>(x.size())) sum += x[v] / static_cast<double>(x.size());
        return sum;
    }
};
INSTANTIATE_TEST_SUITE_P(Settings, Ground,
                         ::testing::Values(Setting{1, "backward_euler"}, Setting{2, "backward_euler"}, Setting{2, "bdf2"},
                                           Setting{2, "midpoint"}, Setting{1, "explicit"}, Setting{2, "explicit"}),
                         [](const auto& p) { return std::string(p.param.scheme) + std::to_string(p.param.order); });

TEST_P(Ground, HoldsWhatLiesOnIt) {
    Simulation simulation = box({{"/material/young", "1e6"}});
    steps(simulation, 240);
    // Its own weight squeezes it by rho g H^2 / (2 E), 5 mm; it sinks in by less than that.
    EXPECT_GT(lowest(simulation), -0.005);
    EXPECT_LT(lowest(simulation), 0);
    EXPECT_LT(velocity(simulation).norm(), 1e-3);
    EXPECT_LT(centre(simulation)[2], 0.5);
    EXPECT_GT(centre(simulation)[2], 0.49);
}

TEST_P(Ground, HoldsOnASlopeThatFrictionBears) {
    Simulation simulation = box({{"/material/young", "1e6"}});
    steps(simulation, 120);
    const double before = centre(simulation)[0];
    simulation.set_gravity({3, 0, -9.81});  // 0.31 of the weight; friction bears 0.5
    steps(simulation, 120);
    EXPECT_LT(velocity(simulation)[0], 0.01);         // creep: friction is in proportion to it below an eighth of the depth a step
    EXPECT_LT(centre(simulation)[0] - before, 0.03);  // it leans, and creeps
}

TEST_P(Ground, SlidesDownASlopeAsCoulombSays) {
    Simulation simulation = box({{"/material/young", "1e6"}});
    steps(simulation, 120);
    simulation.set_gravity({9.81, 0, -9.81});
    steps(simulation, 60);
    const double then = velocity(simulation)[0];
    steps(simulation, 60);
    EXPECT_NEAR(velocity(simulation)[0] - then, 9.81 * (1 - 0.5), 0.05 * 9.81 * 0.5);
}

TEST_P(Ground, WithoutFrictionMomentumAlongItStays) {
    Simulation simulation = box({{"/ground", R"({"friction": 0})"}});
    const PerVertex<Vec3>& rest = simulation.model().tree.rest();
    simulation.place(rest, PerVertex<Vec3>(rest.size(), Vec3(2, 1, 0)));
    steps(simulation, 60);
    // To the tolerance of steps with contact, 1e-2 of a residual; explicit steps keep the momentum of the lumped mass, which this is not with quadratic tets.
    const double tolerance = GetParam().scheme == std::string("explicit") && GetParam().order == 2 ? 0.02 : 5e-3;
    EXPECT_NEAR(velocity(simulation)[0], 2, tolerance);
    EXPECT_NEAR(velocity(simulation)[1], 1, tolerance);
}

/// Thrown at it at 20 m/s, twice as fast as waves of its material: it is pressed flat, jumps off, and comes to lie on it.
TEST_P(Ground, SurvivesAnImpact) {
    Simulation simulation = box({{"/damping", R"({"mass": 2, "stiffness": 0.01})"}});
    const PerVertex<Vec3>& rest = simulation.model().tree.rest();
    PerVertex<Vec3> x = rest;
    for (Vec3& p : x) p[2] += 0.5;
    simulation.place(x, PerVertex<Vec3>(rest.size(), Vec3(0, 0, -20)));
    for (int i = 0; i < 600; ++i) {
        const StepReport r = simulation.step();
        ASSERT_FALSE(r.rejected);
        ASSERT_TRUE(std::isfinite(lowest(simulation))) << "step " << i;
    }
    EXPECT_LT(velocity(simulation).norm(), 0.05);
    EXPECT_GT(lowest(simulation), -0.05);
}

TEST_P(Ground, GoesOnToTheBitFromASnapshot) {
    Simulation simulation = box({});
    steps(simulation, 30);
    ASSERT_LT(lowest(simulation), 0);  // it is in contact
    const std::string state = simulation.snapshot();
    steps(simulation, 30);
    Simulation again = box({});
    again.restore(state);
    steps(again, 30);
    EXPECT_EQ(again.hash(), simulation.hash());
}

TEST(GroundScene, NothingTouchesAnythingWithoutIt) {
    const auto model = box_model();
    EXPECT_FALSE(model->ground);
    Simulation simulation(model);
    simulation.set_gravity({0, 0, -9.81});
    for (int i = 0; i < 30; ++i) simulation.step();
    EXPECT_NEAR(simulation.momentum().linear[2], -9.81 * 0.5 * model->mass, 1e-4 * model->mass);
}

TEST(GroundScene, PointsOfEveryTetAreOfItsSurface) {
    const auto model = box_model({{"/ground", "{}"}});
    const TetTree& tree = model->tree;
    std::size_t with = 0;
    for (TetId t : ids<TetId>(tree.tet_count())) {
        EXPECT_LE(model->ground->points(t).size(), 14U);
        with += !model->ground->points(t).empty();
        for (std::uint32_t s : model->ground->points(t)) {
            TetId up = model->ground->attachments()[s].leaf;
            while (tree.level_of(up) > tree.level_of(t)) up = tree.parent(up);
            EXPECT_EQ(up, t);
        }
    }
    EXPECT_GT(with, tree.root_count() / 2);
}

TEST(GroundScene, RefusesWhatIsNoGround) {
    for (const char* bad : {"5", R"({"height": "low"})", R"({"friction": -1})", R"({"friction": 11})", R"({"depth": 1})"})
        EXPECT_THROW(box_model({{"/ground", bad}}), InputError) << bad;
}

}  // namespace
}  // namespace tetfront
