#include "server/render/geometry.hpp"

#include "engine/base/error.hpp"
#include "tests/support/blob_frame.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

using Eigen::Vector3f;

Vector3f vector(const Point& p) { return {p[0], p[1], p[2]}; }

TEST(VertexFaces, NormalsOfASphereAreRadialHoweverItIsCut) {
    // An octahedron subdivided unevenly: all points on a sphere, triangles of very different size.
    std::vector<Point> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                           {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    points.push_back({0.6F, 0.64F, 0.48F});
    triangles.erase(triangles.begin());
    triangles.insert(triangles.end(), {{0, 2, 6}, {2, 4, 6}, {4, 0, 6}});
    std::vector<Point> normals;
    VertexFaces(triangles, points.size()).normals(points, normals);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((vector(normals[i]) - vector(points[i])).norm(), 1e-5) << i;
}

TEST(VertexFaces, SurvivesDegenerateInput) {
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 0, 1}};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<Point> points = {{0, 0, 0}, {0, 0, 0}, {nan, 0, 0}, {5, 5, 5}};
    std::vector<Point> normals;
    VertexFaces(triangles, points.size()).normals(points, normals);
    for (const Point& n : normals) EXPECT_NEAR(vector(n).norm(), 1, 1e-6);
    EXPECT_THROW(VertexFaces(triangles, 2), LogicError);
}

TEST(Geometry, ColoursFollowLevelAndStiffness) {
    const auto frame = blob_frame(6);
    const auto level = surface_colours(*frame, View{});
    View by_stiffness;
    by_stiffness.colouring = Colouring::stiffness;
    const auto stiffness = surface_colours(*frame, by_stiffness);
    ASSERT_EQ(level.size(), frame->surface.size());
    ASSERT_EQ(stiffness.size(), frame->surface.size());
    for (std::size_t i = 0; i < level.size(); ++i) {
        const Rgb a = level_colour(frame->topology->surface_level[i]);
        const Rgb b = map_colour(stiffness_position(frame->model->young[i], frame->model->young_range));
        EXPECT_EQ(level[i], (std::array<std::uint8_t, 4>{a.r, a.g, a.b, 255}));
        EXPECT_EQ(stiffness[i], (std::array<std::uint8_t, 4>{b.r, b.g, b.b, 255}));
    }
}

TEST(Geometry, BoundsHoldEverythingFinite) {
    Frame frame;
    EXPECT_FALSE(bounds(frame, true).isEmpty());
    frame.surface = {{0, 0, 0}, {1, 2, 3}, {std::numeric_limits<float>::infinity(), 0, 0}};
    frame.front_positions = {{-1, 0, 0}};
    frame.pulls = {{{0, 0, 0}, {0, 9, 0}, 1}};
    EXPECT_EQ(bounds(frame, false).min(), Vector3f(0, 0, 0));
    EXPECT_EQ(bounds(frame, false).max(), Vector3f(1, 9, 3));
    EXPECT_EQ(bounds(frame, true).min(), Vector3f(-1, 0, 0));
}

TEST(Geometry, ForcesHaveArrowsInProportionUpToALimit) {
    FrameModel model;
    model.rest_box = {0, 0, 0, 0, 0, 2};  // radius 1
    model.young_range = {1e4F, 1e6F};
    EXPECT_EQ(force_tip(model, {{1, 2, 3}, {500, 0, 0}}), (Point{1.5F, 2, 3}));
    EXPECT_EQ(force_tip(model, {{1, 2, 3}, {0, -1e9F, 0}}), (Point{1, 0.5F, 3}));
    EXPECT_NEAR(force_tip(model, {{1, 2, 3}, {0, 0, 1e-6F}})[2], 3.33F, 1e-6) << "too short to be seen otherwise";
    EXPECT_EQ(force_tip(model, {{1, 2, 3}, {0, 0, 0}}), (Point{1, 2, 3}));
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(force_tip(model, {{1, 2, 3}, {nan, 0, 0}}), (Point{1, 2, 3}));
    model.young_range = {0, 0};
    EXPECT_EQ(force_tip(model, {{1, 2, 3}, {1, 0, 0}}), (Point{1, 2, 3})) << "no scale, no arrow";
    Frame frame;
    frame.model = std::make_shared<FrameModel>(FrameModel{.triangles = {}, .young = {}, .young_range = {1e4F, 1e4F}, .rest_box = {0, 0, 0, 0, 0, 2}});
    frame.surface = {{0, 0, 0}};
    frame.forces = {{{0, 0, 0}, {1000, 0, 0}}};
    EXPECT_EQ(bounds(frame, false).max(), Vector3f(1, 0, 0));
    EXPECT_EQ(bounds(frame, false, false).max(), Vector3f(0, 0, 0));
}

TEST(Geometry, ArrowIsClosedAndPointsOutwards) {
    for (const Point to : {Point{0, 0, 2}, Point{1, -3, 0.5F}, Point{0.001F, 0, 0}, Point{0, 0, 0}}) {
        Solid solid;
        append_arrow(solid, {0, 0, 0}, to, 0.02F);
        ASSERT_EQ(solid.positions.size(), solid.normals.size());
        float volume = 0;
        for (const auto& t : solid.triangles) {
            const Vector3f a = vector(solid.positions[t[0]]), b = vector(solid.positions[t[1]]);
            const Vector3f c = vector(solid.positions[t[2]]);
            volume += a.dot(b.cross(c)) / 6;
            const Vector3f flat = (b - a).cross(c - a);
            if (flat.norm() < 1e-9F) continue;
            EXPECT_GT(flat.normalized().dot(vector(solid.normals[t[0]])), -0.5F) << "faces outwards as its normal says";
        }
        EXPECT_GT(volume, 0);
        for (const Point& p : solid.positions) EXPECT_TRUE(vector(p).allFinite());
    }
}

}  // namespace
}  // namespace tetfront
