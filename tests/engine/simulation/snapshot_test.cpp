// A snapshot is complete when what goes on from it cannot be told from what was never interrupted; and it is refused
// whole when anything in it is wrong.
#include "engine/simulation/snapshot.hpp"

#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "tests/support/scenes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tetfront {
namespace {

using testing::box_model;
using testing::cantilever_model;

/// A beam with a pull, a changed front, gravity from the timeline and a pin that lets go in the middle of the second part.
std::shared_ptr<const Model> eventful_model(const char* order, std::vector<Override> more = {}) {
    more.insert(more.end(), {{"/front/order", order},
                             {"/front/tolerance", "0.05"},
                             {"/timeline", R"([{"time": 0.3, "gravity": [0, 2, -12]}, {"time": 1.2, "release": 0}])"}});
    return cantilever_model(more);
}

/// What a user does meanwhile, by the number of the step.
void command(Simulation& simulation, int step) {
    if (step == 5) simulation.begin_pull(7, {3, Vec3(0.2, 0.3, 0.5)}, Vec3(2.5, 0.5, 1.5));
    if (step == 20) simulation.set_tolerance(0.01);
    if (step == 25) simulation.begin_pull(8, {40, Vec3(0.5, 0.25, 0.25)}, Vec3(1, -0.5, 0));
    if (step == 40) simulation.set_gravity({1, 0, -5});
    if (step == 70) simulation.end_pull(7);
    if (step == 80) simulation.set_budget(400, 0);
}
void run(Simulation& simulation, int from, int to) {
    for (int i = from; i < to; ++i) {
        command(simulation, i);
        simulation.step();
    }
}

class SnapshotOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Orders, SnapshotOf, ::testing::Values("1", "2"));

TEST_P(SnapshotOf, ARunGoesOnToTheBit) {
    const auto model = eventful_model(GetParam());
    Simulation simulation(model);
    run(simulation, 0, 60);
    const std::string saved = simulation.snapshot();
    const std::uint64_t at_60 = simulation.hash();
    run(simulation, 60, 120);
    const std::uint64_t at_120 = simulation.hash();
    ASSERT_NE(at_60, at_120);
    const std::string end = simulation.snapshot();

    simulation.restore(saved);
    EXPECT_EQ(simulation.hash(), at_60);
    EXPECT_TRUE(simulation.snapshot() == saved);
    simulation.front().validate();
    run(simulation, 60, 120);
    EXPECT_EQ(simulation.hash(), at_120);
    EXPECT_TRUE(simulation.snapshot() == end);

    Simulation fresh(model);
    fresh.restore(saved);
    run(fresh, 60, 120);
    EXPECT_EQ(fresh.hash(), at_120);
    EXPECT_TRUE(fresh.snapshot() == end);

    const auto again = eventful_model(GetParam());  // built anew, as by another process
    Simulation other(again);
    other.restore(saved);
    run(other, 60, 120);
    EXPECT_TRUE(other.snapshot() == end);
}

TEST_P(SnapshotOf, ItsFrameIsTheSameFrame) {
    const auto model = eventful_model(GetParam());
    Simulation simulation(model), other(model);
    run(simulation, 0, 45);
    other.restore(simulation.snapshot());
    const auto a = simulation.frame(0, Field::error), b = other.frame(0, Field::error);
    EXPECT_EQ(a->surface, b->surface);
    EXPECT_EQ(a->front_positions, b->front_positions);
    EXPECT_EQ(a->field_values, b->field_values);
    EXPECT_EQ(a->topology->edges, b->topology->edges);
    EXPECT_EQ(a->status.estimate, b->status.estimate);
    EXPECT_EQ(a->status.step, b->status.step);
    EXPECT_EQ(a->status.time, b->status.time);
    EXPECT_EQ(a->status.tolerance, b->status.tolerance);
    EXPECT_EQ(a->status.solver_iterations, b->status.solver_iterations);
    EXPECT_EQ(a->status.free_vertices, b->status.free_vertices);
    ASSERT_EQ(a->pulls.size(), 2U);
    EXPECT_EQ(a->pulls[1].force, b->pulls[1].force);
}

TEST(Snapshot, ARestoredFrontIsANewEpochOfFrames) {
    const auto model = eventful_model("2");
    Simulation simulation(model);
    const std::string start = simulation.snapshot();
    run(simulation, 0, 30);
    const auto before = simulation.frame();
    simulation.restore(start);
    const auto after = simulation.frame();
    EXPECT_GT(after->topology->epoch, before->topology->epoch);
    EXPECT_EQ(after->front_positions.size(), simulation.front().vertices().size());
}

void expect_refusal(Simulation& simulation, const std::string& bytes, const std::string& part) {
    const std::string before = simulation.snapshot();
    try {
        simulation.restore(bytes, "run.state");
        ADD_FAILURE() << "accepted; expected: " << part;
    } catch (const InputError& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find(part), std::string::npos) << text;
        EXPECT_EQ(text.find("run.state"), 0U) << text;
        EXPECT_FALSE(error.remedy.empty());
    }
    EXPECT_TRUE(simulation.snapshot() == before);
}

TEST(Snapshot, OtherModelsAndSettingsAreRefused) {
    Simulation simulation(box_model());
    simulation.step();
    const std::string saved = simulation.snapshot();
    for (const Override& other : std::vector<Override>{{"/material/young", "1.1e5"},
                                                       {"/material/density", "1001"},
                                                       {"/damping", R"({"mass": 0.1})"},
                                                       {"/mesh/box/high", "[2, 1, 1.01]"},
                                                       {"/mesh/box/cells", "[4, 2, 1]"},
                                                       {"/levels", "1"},
                                                       {"/front/order", "1"},
                                                       {"/front/min_level", "1"},
                                                       {"/front/max_level", "0"},
                                                       {"/front/tolerance", "0.5"},
                                                       {"/gravity", "[0, 0, -1]"},
                                                       {"/time_step", "0.01"},
                                                       {"/solver/newton_iterations", "3"},
                                                       {"/solver/scheme", "\"midpoint\""},
                                                       {"/solver/cg_tolerance", "1e-5"},
                                                       {"/timeline", R"([{"time": 1, "gravity": [0, 0, 0]}])"},
                                                       {"/pins", R"([{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}])"},
                                                       {"/forces", R"([{"region": {"half_space": {"point": [0.1, 0, 0], "normal": [1, 0, 0]}}, "force": [1, 0, 0]}])"}}) {
        SCOPED_TRACE(other.first);
        Simulation another(box_model({other}));
        expect_refusal(another, saved, "belongs to other settings of this scene");
    }
    Simulation named(box_model({{"/title", "\"A title\""}, {"/view", R"({"background": "dark"})"}}));
    named.restore(saved);  // names and views steer nothing
    EXPECT_EQ(named.hash(), simulation.hash());
}

TEST(Snapshot, DamagedAndCutFilesAreRefusedAtEveryByte) {
    const auto model = box_model({{"/mesh/box/cells", "[1, 1, 1]"}});
    Simulation simulation(model);
    simulation.begin_pull(1, {0, Vec3::Constant(1.0 / 3)}, Vec3(-1, 1, 2));
    for (int i = 0; i < 3; ++i) simulation.step();
    const std::string saved = simulation.snapshot();
    Simulation other(model);
    const std::uint64_t before = other.hash();
    const auto refused = [&](const std::string& bytes) {
        try {
            other.restore(bytes);
        } catch (const InputError&) {
            return true;
        }
        return false;
    };
    for (std::size_t at = 0; at < saved.size(); at += at < 200 ? 1 : 7) {
        EXPECT_TRUE(refused(saved.substr(0, at))) << "cut at " << at;
        std::string damaged = saved;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        EXPECT_TRUE(refused(damaged)) << "byte " << at;
    }
    EXPECT_TRUE(refused(saved + "x"));
    EXPECT_EQ(other.hash(), before);
    expect_refusal(other, "", "is no state of a simulation");
    expect_refusal(other, "{}", "is no state of a simulation");
    expect_refusal(other, saved.substr(0, saved.size() / 2), "is cut short");
    std::string version = saved;
    version[8] = 99;
    expect_refusal(other, version, "has format version 99, not ");
}

TEST(Snapshot, NumbersOutOfRangeAreRefusedThoughTheChecksumIsRight) {
    const auto model = box_model();
    Simulation simulation(model);
    simulation.begin_pull(1, {0, Vec3::Constant(1.0 / 3)}, Vec3(-1, 1, 2));
    for (int i = 0; i < 3; ++i) simulation.step();
    const Snapshot good = decode(simulation.snapshot(), "run.state");
    Simulation other(model);
    const auto refused = [&](const char* what, const auto& change) {
        SCOPED_TRACE(what);
        Snapshot bad = good;
        change(bad);
        expect_refusal(other, encode(bad), "");
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused("NaN position", [&](Snapshot& s) { s.motion[3][1] = nan; });
    refused("huge speed", [&](Snapshot& s) { s.motion[3][4] = 1e300; });
    refused("a vertex less", [&](Snapshot& s) { s.motion.pop_back(); });
    refused("a tet less", [&](Snapshot& s) { s.active.pop_back(); });
    refused("a tet twice", [&](Snapshot& s) { s.active.push_back(s.active.back()); });
    refused("a tet that is none", [&](Snapshot& s) { s.active.back() = TetId(1 << 30); });
    refused("a negative tet", [&](Snapshot& s) { s.active.front() = TetId(-5); });
    refused("a tet and its child", [&](Snapshot& s) { s.active.push_back(model->tree.children(s.active.front())[0]); });
    refused("no tets", [&](Snapshot& s) { s.active.clear(), s.motion.clear(); });
    refused("tolerance 0", [&](Snapshot& s) { s.tolerance = 0; });
    refused("gravity", [&](Snapshot& s) { s.gravity[2] = nan; });
    refused("budget", [&](Snapshot& s) { s.budget_tets = 0; });
    refused("time", [&](Snapshot& s) { s.time = -1; });
    refused("energy", [&](Snapshot& s) { s.reference_energy = nan; });
    refused("a pull at no leaf", [&](Snapshot& s) { s.pulls[0].leaf = 0; });
    refused("a pull nowhere", [&](Snapshot& s) { s.pulls[0].leaf = -1; });
    refused("a pull's place", [&](Snapshot& s) { s.pulls[0].barycentric[2] = nan; });
    refused("a pull's target", [&](Snapshot& s) { s.pulls[0].target[2] = 1e12; });
    refused("a pull twice", [&](Snapshot& s) { s.pulls.push_back(s.pulls[0]); });
    refused("a rest of no tet", [&](Snapshot& s) { s.rests = {{std::uint64_t{1} << 40, 9}}; });
    refused("a truth of 2", [&](Snapshot& s) { s.converged = 2; });
    other.restore(encode(good));
    EXPECT_EQ(other.hash(), simulation.hash());
}

TEST(Snapshot, FilesAreWrittenWhole) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.state";
    const auto model = box_model();
    Simulation simulation(model), other(model);
    simulation.begin_pull(1, {0, Vec3::Constant(1.0 / 3)}, Vec3(-1, 1, 2));
    simulation.step();
    save_snapshot(file, simulation);
    simulation.step();
    save_snapshot(file, simulation);  // replaces the first
    load_snapshot(file, other);
    EXPECT_EQ(other.hash(), simulation.hash());
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
    EXPECT_THROW(load_snapshot(folder.path() / "none.state", other), InputError);
    EXPECT_THROW(load_snapshot(folder.write("empty.state", ""), other), InputError);
    EXPECT_EQ(other.hash(), simulation.hash());
}

}  // namespace
}  // namespace tetfront
