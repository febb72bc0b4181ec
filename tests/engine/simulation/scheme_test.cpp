// The schemes of time: how fast they converge, what they do to energy and momentum, how they agree; equilibrium.

#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/mechanics/explicit.hpp"
#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

using testing::box_model;
using testing::cantilever_model;

class SchemeOfOrder : public ::testing::TestWithParam<int> {
 protected:
    [[nodiscard]] Override order() const { return {"/front/order", std::to_string(GetParam())}; }

    /// Twelve roots, one front of them for the whole run, everything solved tightly.
    [[nodiscard]] Simulation beam(const std::string& scheme, double time_step) const {
        std::ostringstream step;
        step << std::setprecision(17) << time_step;
        return Simulation(cantilever_model({order(),
                                            {"/mesh/box/cells", "[2, 1, 1]"},
                                            {"/levels", "1"},
                                            {"/front/max_level", "0"},
                                            {"/gravity", "[0, 0, 0]"},
                                            {"/solver/scheme", "\"" + scheme + "\""},
                                            {"/solver/newton_iterations", "30"},
                                            {"/solver/newton_tolerance", "1e-9"},
                                            {"/solver/cg_tolerance", "1e-6"},
                                            {"/time_step", step.str()}}));
    }
    /// Swings upwards from the rest shape.
    static void kick(Simulation& simulation) {
        const PerVertex<Vec3>& rest = simulation.model().tree.rest();
        PerVertex<Vec3> v(rest.size(), Vec3::Zero());
        for (VertexId i : ids<VertexId>(v.size())) v[i] = Vec3(0, 0, 0.2 * rest[i][0] * rest[i][0]);
        simulation.place(rest, v);
    }
    [[nodiscard]] PerVertex<Vec3> swing(const std::string& scheme, int steps) const {
        Simulation simulation = beam(scheme, 0.25 / steps);
        kick(simulation);
        for (int i = 0; i < steps; ++i) EXPECT_FALSE(simulation.step().rejected);
        return simulation.all_positions();
    }
};
INSTANTIATE_TEST_SUITE_P(Orders, SchemeOfOrder, ::testing::Values(1, 2));

double distance(const PerVertex<Vec3>& a, const PerVertex<Vec3>& b) {
    double sum = 0;
    for (VertexId v : ids<VertexId>(a.size())) sum += (a[v] - b[v]).squaredNorm();
    return std::sqrt(sum);
}

TEST_P(SchemeOfOrder, ConvergesInTimeAsItShould) {
    struct Case {
        const char* scheme;
        double rate;
        int coarsest;
    };
    for (const auto& [scheme, rate, coarsest] : {Case{"backward_euler", 1, 64}, {"midpoint", 2, 32}, {"bdf2", 2, 64}, {"explicit", 2, 512}}) {
        // (Symplectic Euler is of first order, but its places are those of Verlet's scheme, of second order, when no force acts at
        // the start, as here.)
        // Differences of successive runs fall with the rate of the error.
        std::array<PerVertex<Vec3>, 4> x;
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = swing(scheme, coarsest << i);
        const double measured = std::log2(distance(x[1], x[2]) / distance(x[2], x[3]));
        EXPECT_NEAR(measured, rate, 0.25) << scheme;
        RecordProperty(scheme, std::to_string(measured));
    }
}

TEST_P(SchemeOfOrder, EnergyOfUndampedMotion) {
    // What is left of a beam's energy after 120 steps of 1/60 s, two seconds of swinging.
    std::map<std::string, double> left;
    for (const char* scheme : {"backward_euler", "midpoint", "bdf2", "explicit"}) {
        Simulation simulation = beam(scheme, 1.0 / 60);
        kick(simulation);
        const auto total = [&] { return simulation.energy().elastic + simulation.energy().kinetic; };
        const double start = total();
        for (int i = 0; i < 120; ++i) simulation.step();
        left[scheme] = total() / start;
        RecordProperty(scheme, std::to_string(left[scheme]));
    }
    EXPECT_NEAR(left["midpoint"], 1, 0.05);
    EXPECT_NEAR(left["explicit"], 1, 0.3);  // with the consistent mass that energies are told by; lumped in the motion
    EXPECT_LT(left["backward_euler"], 0.85);
    EXPECT_LT(1 - left["bdf2"], 0.5 * (1 - left["backward_euler"]));
    EXPECT_LT(left["bdf2"], 1);
}

TEST_P(SchemeOfOrder, ExplicitFreeFallIsExactAndKeepsMomentum) {
    Simulation simulation(box_model({order(), {"/gravity", "[0, 0, -10]"}, {"/solver/scheme", "\"explicit\""}}));
    StepReport report;
    for (int i = 0; i < 60; ++i) report = simulation.step();
    EXPECT_GT(report.substeps, 0);
    EXPECT_EQ(report.solver_iterations, 0);
    const auto x = simulation.all_positions();
    const Vec3 fallen = x[VertexId(0)] - simulation.model().tree.rest(VertexId(0));
    EXPECT_NEAR(fallen[2], -5, 0.1);  // first order in the substep
    for (VertexId v : ids<VertexId>(x.size())) EXPECT_LT((x[v] - simulation.model().tree.rest(v) - fallen).norm(), 1e-9);
}

TEST_P(SchemeOfOrder, ExplicitAgreesWithImplicitOnFrontsWithHangingVertices) {
    const auto run = [&](const char* scheme) {
        Simulation simulation(cantilever_model({order(), {"/damping", R"({"mass": 1, "stiffness": 0.002})"}, {"/solver/scheme", scheme},
                                                {"/material/young", "1e6"}, {"/front/tolerance", GetParam() == 1 ? "0.1" : "0.003"},
                                                {"/time_step", "0.002"}}));
        std::uint32_t hanging = 0;
        for (int i = 0; i < 150; ++i) {
            const StepReport r = simulation.step();
            EXPECT_FALSE(r.rejected);
            hanging = std::max(hanging, r.hanging_vertices);
        }
        EXPECT_GT(hanging, 0u);
        return simulation.all_positions();
    };
    const auto a = run("\"explicit\""), b = run("\"backward_euler\"");
    const auto rest = cantilever_model({order()})->tree.rest();
    EXPECT_GT(distance(b, rest), 0.1);
    EXPECT_LT(distance(a, b), 0.05 * distance(b, rest));
}

TEST_P(SchemeOfOrder, ExplicitStaysBoundedUnderPullsAndTellsWhenItIsTooStiff) {
    Simulation soft(cantilever_model({order(), {"/solver/scheme", "\"explicit\""}, {"/damping", R"({"mass": 2})"}}));
    soft.begin_pull(1, {40, Vec3::Constant(1.0 / 3)}, Vec3(9, 9, 9));
    double most = 0;
    for (int i = 0; i < 60; ++i) {
        const StepReport r = soft.step();
        EXPECT_FALSE(r.rejected) << i;
        most = std::max(most, soft.energy().elastic + soft.energy().kinetic);
    }
    EXPECT_LT(most, 1e6);
    Simulation stiff(cantilever_model({order(), {"/solver/scheme", "\"explicit\""}, {"/material/young", "1e14"}, {"/time_step", "1"}}));
    const StepReport r = stiff.step();
    EXPECT_TRUE(r.rejected);
    EXPECT_NE(r.warning.find("use an implicit scheme"), std::string::npos) << r.warning;
}

TEST_P(SchemeOfOrder, AutomaticTakesTheCheaperOne) {
    const auto substeps = [&](const char* young) {
        Simulation simulation(cantilever_model({order(), {"/solver/scheme", "\"auto\""}, {"/material/young", young}, {"/gravity", "[0, 0, -1e-3]"}}));
        EXPECT_EQ(simulation.step().substeps, 0) << "the implicit cost is measured first";
        int last = 0;
        for (int i = 0; i < 4; ++i) last = simulation.step().substeps;
        return last;
    };
    EXPECT_EQ(substeps("1e2"), 1);   // one force evaluation against a linear system
    EXPECT_EQ(substeps("1e11"), 0);  // thousands against one
}

TEST_P(SchemeOfOrder, SettlesWhereADampedRunEnds) {
    std::vector<Override> scene = {order(), {"/material/young", "5e5"}, {"/damping", R"({"mass": 4, "stiffness": 0.01})"},
                                   {"/mesh/box/cells", "[2, 1, 1]"}, {"/levels", "1"}, {"/front/max_level", "0"}, {"/solver/newton_iterations", "5"}};
    Simulation run(cantilever_model(scene));
    for (int i = 0; i < 600; ++i) run.step();
    Simulation still(cantilever_model(scene));
    const StepReport r = still.settle();
    EXPECT_TRUE(r.converged) << r.warning;
    EXPECT_EQ(r.time, 0);
    EXPECT_EQ(still.energy().kinetic, 0);
    const auto& rest = run.model().tree.rest();
    EXPECT_GT(distance(run.all_positions(), rest), 0.1);
    EXPECT_LT(distance(run.all_positions(), still.all_positions()), 1e-4 * distance(run.all_positions(), rest));

    scene.push_back({"/solver/start", "\"equilibrium\""});
    Simulation started(cantilever_model(scene));
    EXPECT_EQ(distance(started.all_positions(), still.all_positions()), 0);
    for (int i = 0; i < 30; ++i) started.step();
    EXPECT_LT(distance(started.all_positions(), still.all_positions()), 1e-4 * distance(run.all_positions(), rest));
}

TEST_P(SchemeOfOrder, SettlingAdaptsTheFrontAndGivesUpOnWhatFalls) {
    Simulation still(cantilever_model({order(), {"/mesh/box/cells", "[2, 1, 1]"}, {"/material/young", "5e5"}, {"/front/tolerance", GetParam() == 1 ? "0.2" : "0.02"}}));
    const StepReport r = still.settle();
    EXPECT_TRUE(r.converged) << r.warning;
    EXPECT_LE(r.estimate, GetParam() == 1 ? 0.2 : 0.02);
    EXPECT_GT(still.front().active().size(), still.model().tree.root_count());
    Simulation falls(box_model({order(), {"/mesh/box/cells", "[2, 1, 1]"}, {"/levels", "1"}, {"/gravity", "[0, 0, -9.81]"}}));
    EXPECT_FALSE(falls.settle().converged);
    EXPECT_THROW(box_model({order(), {"/solver/start", "\"equilibrium\""}}), InputError);
}

TEST(Explicit, TheBoundOfATetIsNearThePapersRule) {
    // 2/w of an isotropic tet against 0.44 x its smallest altitude / the speed of pressure waves, found by trial.
    const double lambda = 3e5, mu = 2e5, density = 1000;
    Sym6 c;
    for (int i = 0; i < 6; ++i)
        for (int j = i; j < 6; ++j) c.upper[Sym6::slot(i, j)] = i < 3 && j < 3 ? lambda + (i == j ? 2 * mu : 0) : i == j ? mu : 0;
    const std::array<Vec3, 4> corners = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    const double rule = 0.44 / std::sqrt(3) / std::sqrt((lambda + 2 * mu) / density);
    const double linear = 2 / std::sqrt(largest_frequency2(1, corners, c, density));
    EXPECT_GT(linear, rule);
    EXPECT_LT(linear, 2 * rule);
    const double quadratic = 2 / std::sqrt(largest_frequency2(2, corners, c, density));
    EXPECT_LT(quadratic, linear);
    EXPECT_GT(quadratic, 0.15 * linear);
    EXPECT_NEAR(largest_frequency2(2, corners, c, 4 * density) * 4, largest_frequency2(2, corners, c, density), 1e-6 * largest_frequency2(2, corners, c, density));
}

}  // namespace
}  // namespace tetfront
