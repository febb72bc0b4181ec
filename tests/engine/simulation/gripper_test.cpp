// What gripper.json is to show: its soft joints bend, its stiff links stay straight, and its finger tips close.
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "engine/simulation/shape.hpp"
#include "engine/simulation/simulation.hpp"
#include "tests/support/project.hpp"

namespace tetfront {
namespace {

TEST(Gripper, JointsBendAndLinksStayStraight) {
    const Scene scene = load_scene(source_folder() / "assets/scenes/gripper.json", {{"/levels", "1"}});
    Shape shape = make_shape(scene);
    const PerTet<std::int32_t> region = shape.roots.region;
    const auto model = build_model(scene, std::move(shape));
    const TetTree& tree = model->tree;
    Simulation simulation(model);
    for (int i = 0; i < 120; ++i) EXPECT_FALSE(simulation.step().rejected);

    const auto x = simulation.all_positions();
    std::array<double, 2> strain{}, volume{};  // of links, of joints
    for (const TetId t : tree.level(0)) {
        const auto& c = tree.corners(t);
        Mat3 rest, now;
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i + 1);
            rest.col(i) = tree.rest(c[k]) - tree.rest(c[0]);
            now.col(i) = x[c[k]] - x[c[0]];
        }
        const Mat3 f = now * rest.inverse();
        const std::size_t part = region[t] == 2 ? 1 : 0;
        strain[part] += tree.volume(t) * ((f.transpose() * f - Mat3::Identity()) / 2).norm();
        volume[part] += tree.volume(t);
    }
    EXPECT_GT(strain[1] / volume[1], 0.05);
    EXPECT_GT(strain[1] / volume[1], 10 * strain[0] / volume[0]);

    double left = -1, right = 1;  // innermost place of each finger tip
    for (const VertexId v : ids<VertexId>(x.size())) {
        if (tree.rest(v).z() > 0.04) continue;
        (tree.rest(v).x() < 0 ? left : right) = tree.rest(v).x() < 0 ? std::max(left, x[v].x()) : std::min(right, x[v].x());
    }
    EXPECT_LT(right - left, 0.02) << "0.18 m at rest";
    EXPECT_GT(right - left, -0.02) << "they must not pass each other";
}

}  // namespace
}  // namespace tetfront
