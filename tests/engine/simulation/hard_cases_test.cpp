// What no scene should be, and what a simulation must survive: no NaN, bounded energy, and rest in the end.

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/fronts.hpp"
#include "tests/support/scenes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tetfront {
namespace {

using testing::box_model;

/// A box of 2 x 1 x 1 m in 12 roots with one level, that damps its motion within a second.
std::shared_ptr<const Model> small_box(std::vector<Override> overrides) {
    overrides.insert(overrides.begin(), {{"/mesh/box/cells", "[2, 1, 1]"},
                                         {"/levels", "1"},
                                         {"/damping", R"({"mass": 4, "stiffness": 0.01})"}});
    return box_model(overrides);
}
const Override clamped{"/pins", R"([{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}])"};
const Override gravity{"/gravity", "[0, 0, -9.81]"};

/// With the front's finest level; the coarsest quadratic front has 12 tets, the finest linear one 96.
Simulation simulate(const std::shared_ptr<const Model>& model) {
    FrontSpec spec = model->scene.front;
    spec.min_level = 99;
    return {model, spec};
}

double farthest(const Simulation& simulation) {
    double most = 0;
    const PerVertex<Vec3> x = simulation.all_positions();
    for (VertexId v : ids<VertexId>(x.size())) {
        if (!x[v].allFinite()) return std::nan("");
        most = std::max(most, (x[v] - simulation.model().tree.rest(v)).norm());
    }
    return most;
}

class HardCase : public ::testing::TestWithParam<int> {
 protected:
    [[nodiscard]] Override order() const { return {"/front/order", std::to_string(GetParam())}; }

    /// Steps, and holds every one against: finite, not given up, total energy never above `most` [J] (elastic and kinetic).
    void steps(Simulation& simulation, int count, double most = 1e300) {
        for (int i = 0; i < count; ++i) {
            const StepReport r = simulation.step();
            inverted = r.inverted_tets;
            newton += r.newton_iterations;
            rejected += r.rejected;
            unconverged += !r.converged;
            const Simulation::Energy e = simulation.energy();
            ASSERT_TRUE(std::isfinite(e.kinetic) && std::isfinite(e.elastic)) << "step " << i;
            ASSERT_LE(e.kinetic + e.elastic, most * (1 + 1e-9)) << "step " << i;
        }
        EXPECT_EQ(rejected, 0);
        RecordProperty("newton", newton);
        RecordProperty("unconverged", unconverged);
    }
    /// The shape is that at rest up to a rigid motion: no elastic energy, no inverted tet.
    void expect_rest_shape(const Simulation& simulation, double start_energy) {
        EXPECT_EQ(inverted, 0);
        EXPECT_LT(simulation.energy().elastic, 1e-6 * start_energy);
        EXPECT_LT(simulation.energy().kinetic, 1e-6 * start_energy);
    }
    static double total(const Simulation& simulation) { return simulation.energy().elastic + simulation.energy().kinetic; }

    int inverted = 0, newton = 0, rejected = 0, unconverged = 0;
};
INSTANTIATE_TEST_SUITE_P(Orders, HardCase, ::testing::Values(1, 2), [](const auto& p) { return "order" + std::to_string(p.param); });

TEST_P(HardCase, AllVerticesAtRandomPlacesComeBack) {
    Simulation simulation = simulate(small_box({order(), clamped}));
    std::mt19937 random(7);
    PerVertex<Vec3> x = simulation.model().tree.rest(), v(x.size(), Vec3::Zero());
    for (Vec3& p : x) p = Vec3(1, 0.5, 0.5) + testing::random_vector(random);
    simulation.place(x, v);
    const double start = total(simulation);
    EXPECT_GT(start, 1e4);
    steps(simulation, 600, start);
    expect_rest_shape(simulation, start);
    EXPECT_LT(farthest(simulation), 1e-3);
}

TEST_P(HardCase, AllVerticesAtOnePointComeBack) {
    Simulation simulation = simulate(small_box({order(), {"/mesh/box/cells", "[2, 2, 2]"}}));
    PerVertex<Vec3> x(simulation.model().tree.vertex_count(), Vec3(1, 0.5, 0.5)), v(x.size(), Vec3::Zero());
    simulation.place(x, v);
    const double start = total(simulation);
    steps(simulation, 600, start);
    expect_rest_shape(simulation, start);
}

TEST_P(HardCase, PressedFlatItComesBack) {
    for (const std::vector<Override>& pins : {std::vector<Override>{}, {clamped}}) {
        std::vector<Override> scene = {order()};
        scene.insert(scene.end(), pins.begin(), pins.end());
        Simulation simulation = simulate(small_box(scene));
        PerVertex<Vec3> x = simulation.model().tree.rest(), v(x.size(), Vec3::Zero());
        for (Vec3& p : x) p[2] = 0.5;
        simulation.place(x, v);
        const double start = total(simulation);
        steps(simulation, 600, start);
        expect_rest_shape(simulation, start);
    }
}

TEST_P(HardCase, TwistedTwiceAndLetGoItUnwinds) {
    Simulation simulation = simulate(small_box({order(), clamped, {"/mesh/box/cells", "[8, 2, 2]"}}));
    PerVertex<Vec3> x = simulation.model().tree.rest(), v(x.size(), Vec3::Zero());
    for (Vec3& p : x) {
        const double angle = 4 * M_PI * p[0] / 2, y = p[1] - 0.5, z = p[2] - 0.5;
        p = {p[0], 0.5 + y * std::cos(angle) - z * std::sin(angle), 0.5 + y * std::sin(angle) + z * std::cos(angle)};
    }
    simulation.place(x, v);
    const double start = total(simulation);
    steps(simulation, 600, start);
    expect_rest_shape(simulation, start);
    EXPECT_LT(farthest(simulation), 1e-3);
}

TEST_P(HardCase, NearlyIncompressible) {
    for (const char* poisson : {"0.49", "0.499"}) {
        Simulation simulation = simulate(small_box({order(), clamped, gravity, {"/material/young", "1e6"}, {"/material/poisson", poisson}}));
        steps(simulation, 300);
        EXPECT_LT(simulation.energy().kinetic, 1e-6 * simulation.energy().elastic) << poisson;
        EXPECT_LT(farthest(simulation), 1) << poisson;
    }
}

TEST_P(HardCase, StiffnessContrastOfAMillion) {
    // Linearised steps alone blow this up.
    for (const char* newton_iterations : {"1", "20"}) {
        Simulation simulation = simulate(
            small_box({order(), clamped, gravity, {"/mesh/box/cells", "[4, 2, 2]"}, {"/solver/newton_iterations", newton_iterations},
                       {"/material", R"({"young": 1e4, "shapes": [{"region": {"box": {"low": [0.6, 0.2, 0.2],
                           "high": [1.4, 0.8, 0.8]}}, "material": {"young": 1e10}}]})"}}));
        steps(simulation, 120);
        EXPECT_LT(farthest(simulation), 8);
    }
}

TEST_P(HardCase, FromJellyToDiamond) {
    for (const char* young : {"1e2", "1e5", "1e8", "1e11"}) {
        Simulation simulation = simulate(small_box({order(), clamped, gravity, {"/material/young", young}}));
        steps(simulation, 300);
        if (std::string(young) == "1e2") continue;  // a thread of hundreds of metres, still on its way
        EXPECT_LT(simulation.energy().kinetic, 1e-4 * simulation.energy().elastic) << young;
        if (std::string(young) == "1e11") {
            EXPECT_LT(farthest(simulation), 1e-5);
            EXPECT_GT(farthest(simulation), 1e-7);
        }
    }
}

TEST_P(HardCase, AMillimetreAndAKilometre) {
    // With E in proportion to the size and time to its root, sag over size is the same at every size.
    std::vector<double> sag;
    for (const double size : {1e-3, 1.0, 1e3}) {
        std::ostringstream high, point, young, damping, step;
        high << "[" << 2 * size << ", " << size << ", " << size << "]";
        point << R"([{"half_space": {"point": [)" << 1e-3 * size << R"(, 0, 0], "normal": [1, 0, 0]}}])";
        young << 1e6 * size;
        damping << R"({"mass": )" << 4 / std::sqrt(size) << "}";
        step << std::sqrt(size) / 60;
        Simulation simulation =
            simulate(small_box({order(), gravity, {"/mesh/box/high", high.str()}, {"/pins", point.str()}, {"/material/young", young.str()},
                                {"/damping", damping.str()}, {"/time_step", step.str()}}));
        steps(simulation, 200);
        sag.push_back(farthest(simulation) / size);
    }
    EXPECT_GT(sag[1], 1e-2);
    EXPECT_NEAR(sag[0] / sag[1], 1, 1e-3);
    EXPECT_NEAR(sag[2] / sag[1], 1, 1e-3);
}

TEST_P(HardCase, TimeStepsShortAndLong) {
    for (const char* step : {"1e-4", "1e-2", "0.1"}) {
        Simulation simulation = simulate(small_box({order(), clamped, gravity, {"/material/young", "1e6"}, {"/time_step", step}}));
        steps(simulation, 200);
        EXPECT_LT(farthest(simulation), 1) << step;
    }
}

TEST_P(HardCase, AHundredTimesGravityOnASoftBox) {
    // The softer one is drawn out to a thread of hundreds of metres, whose tets may stay tangled when it snaps back: a
    // corotated material has more than one place of rest then.
    for (const char* young : {"1e4", "1e6"}) {
        Simulation simulation = simulate(small_box({order(), clamped, {"/gravity", "[0, 0, -981]"}, {"/material/young", young}}));
        steps(simulation, 200);
        const double loaded = total(simulation);
        simulation.set_gravity(Vec3::Zero());
        steps(simulation, 600);
        EXPECT_LT(total(simulation), 1e-3 * loaded);
        if (std::string(young) == "1e4") continue;
        expect_rest_shape(simulation, loaded);
        EXPECT_LT(farthest(simulation), 1e-2);
    }
}

TEST_P(HardCase, DraggedAroundAtAHundredMetresASecond) {
    Simulation simulation = simulate(small_box({order(), clamped}));
    std::mt19937 random(3);
    Vec3 cursor(2, 0.5, 0.5);
    simulation.begin_pull(1, {20, Vec3::Constant(1.0 / 3)}, cursor);
    double most = 0;
    for (int i = 0; i < 600; ++i) {
        if (i % 10 == 0) simulation.begin_pull(1, {static_cast<std::uint32_t>(i % 80), Vec3::Constant(1.0 / 3)}, cursor);
        cursor += testing::random_vector(random).normalized() * (100.0 / 60);
        simulation.move_pull(1, cursor);
        steps(simulation, 1);
        most = std::max(most, total(simulation));
        ASSERT_LT(farthest(simulation), 20) << "step " << i;
    }
    simulation.end_pull(1);
    steps(simulation, 600);
    expect_rest_shape(simulation, most);
    EXPECT_LT(farthest(simulation), 1e-2);
}

TEST_P(HardCase, NoPinsAtAll) {
    Simulation simulation = simulate(small_box({order(), gravity, {"/damping", R"({"mass": 0})"}}));
    simulation.begin_pull(1, {3, Vec3::Constant(1.0 / 3)}, Vec3(9, 9, 9));
    steps(simulation, 30);
    simulation.end_pull(1);
    steps(simulation, 120);
    EXPECT_LT(simulation.momentum().linear[2], -1000);
}

TEST_P(HardCase, EverythingPinned) {
    Simulation simulation = simulate(small_box({order(), gravity, {"/pins", R"([{"half_space": {"point": [9, 0, 0], "normal": [1, 0, 0]}}])"}}));
    simulation.begin_pull(1, {3, Vec3::Constant(1.0 / 3)}, Vec3(9, 9, 9));
    steps(simulation, 20);
    EXPECT_EQ(unconverged, 0);
    EXPECT_EQ(farthest(simulation), 0);
}

/// A mesh of tets from text, in Medit's format.
std::shared_ptr<const Model> tets_model(const char* vertices, const char* tets, std::vector<Override> overrides) {
    const TemporaryFolder folder;  // of each test its own: they run side by side
    const auto file = folder.write("hard_case.mesh", std::string("MeshVersionFormatted 2\nDimension 3\nVertices\n") + vertices + "\nTetrahedra\n" + tets + "\nEnd\n");
    std::vector<Override> all = {{"/mesh", R"({"tets": {"file": ")" + file.string() + R"("}})"},
                                 {"/damping", R"({"mass": 4, "stiffness": 0.01})"}, {"/levels", "1"}};
    all.insert(all.end(), overrides.begin(), overrides.end());
    return box_model(all);
}

TEST_P(HardCase, ASingleTet) {
    Simulation simulation = simulate(tets_model("4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0", "1\n1 2 3 4 0", {order()}));
    PerVertex<Vec3> x = simulation.model().tree.rest(), v(x.size(), Vec3::Zero());
    for (Vec3& p : x) p = -p;  // inside out
    simulation.place(x, v);
    const double start = total(simulation);
    steps(simulation, 300, start);
    expect_rest_shape(simulation, start);
}

TEST_P(HardCase, TetsAsFlatAsOneDegree) {
    // Two slivers: the fourth corner hardly leaves the plane of the others.
    Simulation simulation = simulate(tets_model("5\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0.0087 0\n0.7 0.3 -0.6 0", "2\n1 2 3 4 0\n1 3 2 5 0",
                                                {order(), gravity, {"/pins", R"([{"box": {"low": [-0.1, -0.1, -0.1], "high": [0.001, 2, 2]}}])"}}));
    simulation.begin_pull(1, {1, Vec3::Constant(1.0 / 3)}, Vec3(0.5, 0.5, 3));
    steps(simulation, 60);
    simulation.end_pull(1);
    simulation.set_gravity(Vec3::Zero());
    const double loaded = total(simulation);
    steps(simulation, 300);
    expect_rest_shape(simulation, loaded);
}

TEST_P(HardCase, TwoPartsThatDoNotTouch) {
    Simulation simulation = simulate(tets_model("8\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n5 0 0 0\n6 0 0 0\n5 1 0 0\n5 0 1 0", "2\n1 2 3 4 0\n5 6 7 8 0",
                                                {order(), gravity, {"/pins", R"([{"box": {"low": [-0.1, -0.1, -0.1], "high": [2, 2, 0.001]}}])"}}));
    steps(simulation, 60);
    double held = 0, fallen = 0;
    const PerVertex<Vec3> x = simulation.all_positions();
    for (VertexId v : ids<VertexId>(x.size())) {
        const Vec3& rest = simulation.model().tree.rest(v);
        double& most = rest[0] < 3 ? held : fallen;
        most = std::max(most, (x[v] - rest).norm());
    }
    EXPECT_LT(held, 0.5);
    EXPECT_GT(fallen, 1);
}

}  // namespace
}  // namespace tetfront
