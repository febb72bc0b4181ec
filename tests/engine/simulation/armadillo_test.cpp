// The paper's observation on figures 11 and 12: under the same force the softer hand gets farther than the stiffer one.
#include <filesystem>

#include <gtest/gtest.h>

#include "engine/simulation/simulation.hpp"
#include "tests/support/project.hpp"

namespace tetfront {
namespace {

/// How much farther the vertices of a force's region have moved along it after half a second than the chest has [m].
double lengthened(int force) {
    const std::string other = "/forces/" + std::to_string(1 - force), mine = "/forces/" + std::to_string(force);
    const Scene scene = load_scene(source_folder() / "assets/scenes/armadillo.json",
                                   {{"/levels", "1"}, {"/mesh/surface/target_tets", "700"}, {"/estimation", R"({"sampled": false})"},
                                    {mine + "/start", "0"}, {mine + "/end", "10"}, {other + "/start", "20"}, {other + "/end", "30"}});
    const auto model = build_model(scene);
    Simulation simulation(model);
    for (int i = 0; i < 30; ++i) simulation.step();
    const auto frame = simulation.frame();
    const auto& rest = model->surface.mesh.positions;
    const ForceSpec& pull = scene.forces[static_cast<std::size_t>(force)];
    const auto moved = [&](const Region& region) {
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for (std::size_t v = 0; v < rest.size(); ++v) {
            if (!contains(region, rest[v])) continue;
            const auto& p = frame->surface[v];
            sum += Vec3(p[0], p[1], p[2]) - rest[v];
            ++count;
        }
        EXPECT_GT(count, 50);
        return sum.dot(pull.force.normalized()) / count;
    };
    return moved(pull.region) - moved(Box{{-0.1, 0, -1}, {0.1, 0.25, 1}});
}

TEST(Armadillo, SofterArmGetsLongerUnderTheSameForce) {
    if (!std::filesystem::exists(source_folder() / "assets/models/armadillo.off"))
        GTEST_SKIP() << "assets/fetch armadillo fetches the model";
    const double soft = lengthened(0), stiff = lengthened(1);
    EXPECT_GT(stiff, 0.001);
    EXPECT_GT(soft, 2 * stiff);  // E differs by ten from hand to hand, but both arms begin at the same chest
}

}  // namespace
}  // namespace tetfront
