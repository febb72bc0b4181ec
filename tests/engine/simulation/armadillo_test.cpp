// The paper's observation on figures 11 and 12: under the same force the softer hand gets farther than the stiffer one.
#include <filesystem>

#include <gtest/gtest.h>

#include "engine/simulation/simulation.hpp"
#include "tests/support/project.hpp"

namespace tetfront {
namespace {

/// Mean distance that the vertices of a force's region have moved outwards after half a second [m].
double pulled(int force) {
    const std::string other = "/forces/" + std::to_string(1 - force), mine = "/forces/" + std::to_string(force);
    const Scene scene = load_scene(source_folder() / "assets/scenes/armadillo.json",
                                   {{"/levels", "1"}, {"/mesh/surface/target_tets", "700"}, {"/estimation", R"({"sampled": false})"},
                                    {mine + "/start", "0"}, {mine + "/end", "10"}, {other + "/start", "20"}, {other + "/end", "30"}});
    const auto model = build_model(scene);
    Simulation simulation(model);
    for (int i = 0; i < 30; ++i) simulation.step();
    const auto frame = simulation.frame();
    double sum = 0;
    int count = 0;
    const auto& rest = model->surface.mesh.positions;
    for (std::size_t v = 0; v < rest.size(); ++v) {
        if (!contains(scene.forces[static_cast<std::size_t>(force)].region, rest[v])) continue;
        sum += std::abs(static_cast<double>(frame->surface[v][0]) - rest[v].x());
        ++count;
    }
    EXPECT_GT(count, 50);
    return sum / count;
}

TEST(Armadillo, SofterHandMovesFartherUnderTheSameForce) {
    if (!std::filesystem::exists(source_folder() / "assets/models/armadillo.off"))
        GTEST_SKIP() << "assets/fetch armadillo fetches the model";
    const double soft = pulled(0), stiff = pulled(1);
    EXPECT_GT(stiff, 0.001);
    EXPECT_GT(soft, 3 * stiff);
}

}  // namespace
}  // namespace tetfront
