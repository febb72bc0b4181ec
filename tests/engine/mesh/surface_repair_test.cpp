#include "engine/mesh/surface_repair.hpp"

#include "tests/engine/mesh/shapes.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

using test_surfaces::surface_volume;

/// Each triangle with vertices of its own, as STL files have them.
SurfaceMesh soup(const SurfaceMesh& mesh) {
    SurfaceMesh out;
    for (const auto& t : mesh.triangles) {
        const auto first = static_cast<std::int32_t>(out.positions.size());
        for (std::int32_t v : t) out.positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
        out.triangles.push_back({first, first + 1, first + 2});
    }
    return out;
}

TEST(SurfaceRepair, SoundSurfaceStays) {
    const SurfaceMesh sound = test_surfaces::torus(1, 0.4);
    SurfaceMesh mesh = sound;
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(mesh.positions, sound.positions);
    EXPECT_EQ(mesh.triangles, sound.triangles);
    EXPECT_EQ(repairs.components, 1u);
    EXPECT_EQ(describe(repairs), "");
}

TEST(SurfaceRepair, WeldsSoup) {
    const SurfaceMesh sound = test_surfaces::sphere({0, 0, 0}, 1, 2);
    SurfaceMesh mesh = soup(sound);
    mesh.positions.emplace_back(9, 9, 9);
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(mesh.positions.size(), sound.positions.size());
    EXPECT_EQ(mesh.triangles.size(), sound.triangles.size());
    EXPECT_EQ(repairs.welded_vertices, 3 * sound.triangles.size() - sound.positions.size());
    EXPECT_EQ(repairs.unused_vertices, 1u);
    EXPECT_EQ(repairs.open_edges, 0u);
    EXPECT_NEAR(surface_volume(mesh), surface_volume(sound), 1e-12);
}

TEST(SurfaceRepair, DropsDegenerateAndDuplicateTriangles) {
    SurfaceMesh mesh = test_surfaces::sphere({0, 0, 0}, 1, 2);
    const double volume = surface_volume(mesh);
    mesh.triangles.push_back({4, 4, 7});
    const auto t = mesh.triangles[5];
    mesh.triangles.push_back({t[1], t[2], t[0]});
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(repairs.degenerate_triangles, 1u);
    EXPECT_EQ(repairs.duplicate_triangles, 1u);
    EXPECT_EQ(repairs.nonmanifold_edges, 0u);
    EXPECT_NEAR(surface_volume(mesh), volume, 1e-12);
}

TEST(SurfaceRepair, TwoSidedSurfaceKeepsOneSide) {
    SurfaceMesh mesh = test_surfaces::sphere({0, 0, 0}, 1, 2);
    const double volume = surface_volume(mesh);
    test_surfaces::append(mesh, test_surfaces::sphere({0, 0, 0}, 1, 2), true);
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(repairs.duplicate_triangles, mesh.triangles.size());
    EXPECT_NEAR(surface_volume(mesh), volume, 1e-12);
}

TEST(SurfaceRepair, TouchingBodiesKeepTheirCommonWall) {
    SurfaceMesh mesh = test_surfaces::cube({0, 0, 0}, {1, 1, 1});
    test_surfaces::append(mesh, test_surfaces::cube({1, 0, 0}, {2, 1, 1}));
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(repairs.duplicate_triangles, 0u);
    EXPECT_NEAR(surface_volume(mesh), 2, 1e-12);
}

TEST(SurfaceRepair, FlippedTrianglesFollowTheirNeighbours) {
    SurfaceMesh mesh = test_surfaces::torus(1, 0.4);
    const SurfaceMesh sound = mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
    const SurfaceRepairs repairs = repair(mesh);
    EXPECT_EQ(repairs.flipped_triangles, (mesh.triangles.size() + 2) / 3);
    EXPECT_NEAR(surface_volume(mesh), surface_volume(sound), 1e-12);
}

TEST(SurfaceRepair, ClosedSurfacesFaceOutwardsAndCavitiesInwards) {
    const double outer = surface_volume(test_surfaces::sphere({0, 0, 0}, 1, 3));
    const double inner = surface_volume(test_surfaces::sphere({0, 0, 0}, 0.5, 3));
    for (bool outer_flipped : {false, true}) {
        for (bool inner_flipped : {false, true}) {
            SurfaceMesh mesh;
            test_surfaces::append(mesh, test_surfaces::sphere({0.1, 0, 0}, 0.5, 3), inner_flipped);
            test_surfaces::append(mesh, test_surfaces::sphere({0, 0, 0}, 1, 3), outer_flipped);
            const SurfaceRepairs repairs = repair(mesh);
            EXPECT_EQ(repairs.components, 2u);
            // Opposite orientations mean a cavity, equal ones a body within a body; the outer one faces outwards.
            const double expected = outer_flipped != inner_flipped ? outer - inner : outer + inner;
            EXPECT_NEAR(surface_volume(mesh), expected, 1e-9);
        }
    }
}

TEST(SurfaceRepair, OpenSurfaceThatEnclosesFacesOutwards) {
    const SurfaceMesh bowl = test_surfaces::part(test_surfaces::sphere({0, 0, 0}, 1, 3), [](const Vec3& c) { return c[2] < 0.4; });
    SurfaceMesh flipped;
    test_surfaces::append(flipped, bowl, true);
    const SurfaceRepairs repairs = repair(flipped);
    EXPECT_EQ(repairs.flipped_triangles, bowl.triangles.size());
    EXPECT_GT(repairs.open_edges, 0u);
    EXPECT_NE(describe(repairs).find("holes"), std::string::npos);
    EXPECT_GT(surface_volume(flipped), 0);
}

}  // namespace
}  // namespace tetfront
