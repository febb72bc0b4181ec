#include "engine/tree/creases.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

Surface boundary(const TetMesh& mesh) {
    const TetTree tree(mesh, 0);
    return embed(boundary_surface(mesh), tree);
}

void expect_same_shape(const Surface& before, const Surface& after) {
    ASSERT_EQ(before.mesh.triangles.size(), after.mesh.triangles.size());
    ASSERT_EQ(after.mesh.positions.size(), after.attachment.size());
    for (std::size_t t = 0; t < before.mesh.triangles.size(); ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto a = static_cast<std::size_t>(before.mesh.triangles[t][i]);
            const auto b = static_cast<std::size_t>(after.mesh.triangles[t][i]);
            ASSERT_LT(b, after.mesh.positions.size());
            EXPECT_EQ(before.mesh.positions[a], after.mesh.positions[b]);
            EXPECT_EQ(before.attachment[a].leaf, after.attachment[b].leaf);
            EXPECT_EQ(before.attachment[a].barycentric, after.attachment[b].barycentric);
        }
    }
}

TEST(Creases, EachFaceOfABoxHasItsOwnVertices) {
    const Surface box = boundary(box_mesh({0, 0, 0}, {3, 2, 1}, {3, 2, 2}));
    const Surface split = split_creases(box, crease_angle);
    expect_same_shape(box, split);
    // 2 (4x3) + 2 (4x3) + 2 (3x3) points on the six faces.
    EXPECT_EQ(split.mesh.positions.size(), 2U * 12 + 2 * 12 + 2 * 9);
    std::vector<std::set<int>> directions(split.mesh.positions.size());
    for (const auto& t : split.mesh.triangles) {
        const auto at = [&](std::size_t i) { return split.mesh.positions[static_cast<std::size_t>(t[i])]; };
        const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        const int direction = static_cast<int>(std::lround(n.x() + 2 * n.y() + 3 * n.z()));
        for (const std::int32_t v : t) directions[static_cast<std::size_t>(v)].insert(direction);
    }
    for (const auto& around : directions) EXPECT_EQ(around.size(), 1U) << "flat around every vertex";
}

TEST(Creases, SmoothSurfacesAreLeftAlone) {
    const Surface box = boundary(box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2}));
    const Surface same = split_creases(box, 100);
    EXPECT_EQ(same.mesh.positions.size(), box.mesh.positions.size());
    EXPECT_EQ(same.mesh.triangles, box.mesh.triangles);
}

TEST(Creases, ASharpEdgeThatEndsInsideDoesNotTearItsEnd) {
    // A fan around vertex 0, pulled up to a cusp along its spoke 0-1: sharp there, smooth everywhere else.
    constexpr int spokes = 12;
    Surface fan;
    fan.mesh.positions.push_back({0, 0, 0});
    for (int i = 0; i < spokes; ++i) {
        const double angle = 2 * 3.14159265358979 * i / spokes, away = std::min(i, spokes - i) * 2 * 3.14159 / spokes;
        fan.mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.6 * std::exp(-2 * away)});
        fan.mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % spokes});
    }
    fan.attachment.resize(fan.mesh.positions.size());
    const Surface split = split_creases(fan, 45);
    for (const auto& t : split.mesh.triangles) EXPECT_EQ(t[0], 0) << "all still hang together round the other way";
    EXPECT_EQ(split.mesh.positions.size(), fan.mesh.positions.size() + 1) << "but the spoke's outer end is two";
    EXPECT_NE(split.mesh.triangles.front()[1], split.mesh.triangles.back()[2]);
}

TEST(Creases, EdgesOfThreeTrianglesAreSharp) {
    Surface book;
    book.mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0.1, 0}, {1, -0.1, 0}};
    book.mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
    book.attachment.resize(5);
    EXPECT_EQ(split_creases(book, crease_angle).mesh.positions.size(), 9U);
}

}  // namespace
}  // namespace tetfront
