// The same scene and commands give the same bits, whatever the number of threads, twice in a row.

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

class Determinism : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Schemes, Determinism, ::testing::Values("backward_euler", "midpoint", "bdf2", "explicit"),
                         [](const auto& p) { return std::string(p.param); });

/// A front of more than a thousand tets, so that every loop has several chunks; it splits and merges, lies on a ground and is pulled.
std::vector<std::uint64_t> run(const std::string& scheme) {
    const auto model = testing::cantilever_model({{"/mesh/box/cells", "[6, 2, 2]"},
                                                  {"/front/tolerance", "0.004"},
                                                  {"/front/min_level", "1"},
                                                  {"/ground", R"({"height": -0.2})"},
                                                  {"/solver/scheme", "\"" + scheme + "\""}});
    Simulation simulation(model);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 10; ++i) {
        if (i == 3) simulation.begin_pull(1, {0, Vec3(1, 0, 0)}, {3, 2, 1});
        if (i == 8) simulation.end_pull(1);
        simulation.step();
        hashes.push_back(simulation.hash());
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
