// The same scene and commands give the same bits, whatever the number of threads, twice in a row.

#include <algorithm>

#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

/// Really so many, also where there are fewer processors.
template <class Work>
auto in_threads(int threads, Work work) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute(work);
}

struct Setting {
    const char* scheme;
    int order;
};
class Determinism : public ::testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Determinism, ::testing::Values(Setting{"backward_euler", 1}, Setting{"backward_euler", 2}, Setting{"midpoint", 2}, Setting{"bdf2", 2},
                                           Setting{"explicit", 1}, Setting{"explicit", 2}),
                         [](const auto& p) { return p.param.scheme + std::to_string(p.param.order); });

/// A front of more than a thousand tets, so that every loop has several chunks; it splits and merges, lies on a ground and is pulled.
std::vector<std::uint64_t> run(const Setting& setting) {
    const std::string scheme = setting.scheme;
    std::vector<Override> overrides = {{"/mesh/box/cells", "[8, 4, 4]"},
                                       {"/front/tolerance", setting.order == 1 ? "0.02" : "0.0005"},
                                       {"/front/order", std::to_string(setting.order)},
                                       {"/solver/scheme", "\"" + scheme + "\""}};
    // Near the ground the midpoint rule is backward Euler.
    if (scheme != "midpoint") overrides.push_back({"/ground", R"({"height": -0.001})"});
    Simulation simulation(testing::cantilever_model(overrides));
    int changes = 0;
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 10; ++i) {
        if (i == 3) simulation.begin_pull(1, {0, Vec3(1, 0, 0)}, {3, 2, 1});
        if (i == 8) simulation.end_pull(1);
        const StepReport r = simulation.step();
        changes += r.splits + r.merges;
        hashes.push_back(simulation.hash());
    }
    EXPECT_GT(changes, 0);
    if (scheme != "midpoint") {
        const PerVertex<Vec3> x = simulation.all_positions();
        EXPECT_LT(std::ranges::min(x, {}, [](const Vec3& p) { return p[2]; })[2], -0.001) << "never touched the ground";
    }
    return hashes;
}

TEST_P(Determinism, BitsDoNotDependOnThreads) {
    const auto one = in_threads(1, [] { return run(GetParam()); });
    EXPECT_NE(one.front(), one.back());
    for (int threads : {2, 8}) EXPECT_EQ(in_threads(threads, [] { return run(GetParam()); }), one) << threads << " threads";
}

}  // namespace
}  // namespace tetfront
