#include "engine/tree/surface.hpp"

#include "engine/mesh/volume_mesh.hpp"
#include "tests/engine/mesh/shapes.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

/// Where the attachment puts the vertex when the tree's vertices are at x.
Vec3 follow(const Attachment& a, const TetTree& tree, const PerVertex<Vec3>& x) {
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += a.barycentric[i] * x[tree.corners(a.leaf)[static_cast<std::size_t>(i)]];
    return p;
}

SurfaceMesh random_points(const Vec3& low, const Vec3& high, std::size_t count) {
    std::mt19937 random(3);
    SurfaceMesh mesh;
    for (std::size_t i = 0; i < count; ++i) {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = std::uniform_real_distribution<double>(low[k], high[k])(random);
        mesh.positions.push_back(p);
    }
    return mesh;
}

TEST(Surface, InsideVerticesAreReproducedByConvexCoordinates) {
    const TetTree tree(box_mesh({0, 0, 0}, {2, 1, 1}, {3, 2, 2}), 3);
    const SurfaceMesh points = random_points({0, 0, 0}, {2, 1, 1}, 2000);
    const Surface surface = embed(points, tree);
    EXPECT_EQ(surface.outside_count, 0u);
    EXPECT_EQ(surface.outside_distance, 0);
    ASSERT_EQ(surface.attachment.size(), points.positions.size());
    for (std::size_t v = 0; v < points.positions.size(); ++v) {
        const Attachment& a = surface.attachment[v];
        EXPECT_TRUE(tree.is_leaf(a.leaf));
        EXPECT_GE(a.barycentric.minCoeff(), 0);
        EXPECT_NEAR(a.barycentric.sum(), 1, 1e-12);
        EXPECT_LT((follow(a, tree, tree.rest()) - points.positions[v]).norm(), 1e-8);
    }
}

TEST(Surface, LeafIsTheOneThatHoldsThePoint) {
    // The centroid of every leaf must find this very leaf.
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {2, 1, 1}), 2);
    SurfaceMesh centroids;
    const auto leaves = tree.level(tree.depth());
    for (TetId t : leaves) {
        Vec3 c = Vec3::Zero();
        for (VertexId v : tree.corners(t)) c += tree.rest(v) / 4;
        centroids.positions.push_back(c);
    }
    const Surface surface = embed(centroids, tree);
    std::size_t i = 0;
    for (TetId t : leaves) {
        EXPECT_EQ(surface.attachment[i].leaf, t);
        EXPECT_LT((surface.attachment[i++].barycentric - Vec4::Constant(0.25)).norm(), 1e-12);
    }
}

TEST(Surface, OutsideVerticesFollowTheNearestLeafAffinely) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), 2);
    SurfaceMesh points;
    points.positions = {{1.25, 0.5, 0.4}, {-0.1, -0.1, -0.1}, {0.5, 0.5, 0.5}};
    const Surface surface = embed(points, tree);
    EXPECT_EQ(surface.outside_count, 2u);
    EXPECT_NEAR(surface.outside_distance, 0.25, 1e-12);
    EXPECT_LT(surface.attachment[0].barycentric.minCoeff(), 0);
    // The leaf touches the nearest point of the box.
    double nearest = 1;
    for (VertexId v : tree.corners(surface.attachment[0].leaf))
        nearest = std::min(nearest, (tree.rest(v) - Vec3(1, 0.5, 0.4)).norm());
    EXPECT_LT(nearest, 0.25);
    const Mat3 a = Mat3::Identity() + 0.3 * Mat3::Random();
    PerVertex<Vec3> moved;
    for (const Vec3& x : tree.rest()) moved.push_back(a * x + Vec3(1, 2, 3));
    for (std::size_t v = 0; v < points.positions.size(); ++v)
        EXPECT_LT((follow(surface.attachment[v], tree, moved) - (a * points.positions[v] + Vec3(1, 2, 3))).norm(),
                  1e-9);
}

TEST(Surface, StaysWholeUnderASmoothDeformation) {
    // A meshed ball, its surface partly outside of the tets, bent smoothly: no edge of the surface may jump.
    const SurfaceMesh ball = test_surfaces::sphere({0, 0, 0}, 1, 4);
    const VolumeMesh coarse = mesh_volume(ball, {.target_tets = 300, .margin = 0});
    const TetTree tree(coarse.mesh, 2);
    const Surface surface = embed(ball, tree);
    EXPECT_GT(surface.outside_count, 0u);
    const auto bend = [](const Vec3& x) { return Vec3(x[0] + 0.3 * x[1] * x[1], x[1], x[2] + 0.2 * x[0] * x[1]); };
    PerVertex<Vec3> moved;
    for (const Vec3& x : tree.rest()) moved.push_back(bend(x));
    double worst = 0;
    for (std::size_t v = 0; v < ball.positions.size(); ++v)
        worst = std::max(worst, (follow(surface.attachment[v], tree, moved) - bend(ball.positions[v])).norm());
    EXPECT_LT(worst, 0.02);
}

TEST(Surface, IsDeterministic) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), 2);
    const SurfaceMesh points = random_points({-0.2, -0.2, -0.2}, {1.2, 1.2, 1.2}, 3000);
    const Surface a = embed(points, tree), b = embed(points, tree);
    for (std::size_t v = 0; v < points.positions.size(); ++v) {
        EXPECT_EQ(a.attachment[v].leaf, b.attachment[v].leaf);
        EXPECT_EQ(a.attachment[v].barycentric, b.attachment[v].barycentric);
    }
}

}  // namespace
}  // namespace tetfront
