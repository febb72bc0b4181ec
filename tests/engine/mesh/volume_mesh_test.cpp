#include "engine/mesh/volume_mesh.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/isosurface_stuffing.hpp"
#include "engine/mesh/surface_repair.hpp"
#include "engine/mesh/winding_number.hpp"
#include "tests/engine/mesh/shapes.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

void expect_sound(const VolumeMesh& result, int target) {
    EXPECT_NO_THROW(validate(result.mesh));
    EXPECT_NEAR(static_cast<double>(result.report.tets), target, 0.2 * target);
    EXPECT_GT(result.report.dihedral[0], stuffing_min_dihedral);
    EXPECT_LT(result.report.dihedral[1], stuffing_max_dihedral);
    EXPECT_EQ(result.report.pinched_edges, 0u);
}

TEST(VolumeMesh, HitsItsTargetForASphere) {
    for (int target : {100, 700, 3000}) {
        const VolumeMesh result = mesh_volume(test_surfaces::sphere({1, 2, 3}, 0.5), {.target_tets = target});
        expect_sound(result, target);
        EXPECT_EQ(result.report.mesh_pieces, 1u);
        EXPECT_LT(result.report.outside_distance, 0.12 * result.report.cell);
        EXPECT_GT(result.report.covered_volume, 0.97);
    }
}

TEST(VolumeMesh, WithoutMarginTheVolumeConverges) {
    const SurfaceMesh torus = test_surfaces::torus(1, 0.4, 96, 48);
    double previous = 1;
    for (int target : {400, 3200, 25600}) {
        const VolumeMesh result = mesh_volume(torus, {.target_tets = target, .margin = 0, .thicken = false});
        expect_sound(result, target);
        const double error = std::abs(result.report.mesh_volume / result.report.surface_volume - 1);
        EXPECT_NEAR(result.report.surface_volume, test_surfaces::surface_volume(torus), 1e-9);
        EXPECT_LT(error, previous / 2);
        previous = error;
    }
    EXPECT_LT(previous, 0.01);
}

TEST(VolumeMesh, OpenHemisphereIsClosedByItsWindingNumber) {
    const SurfaceMesh bowl = test_surfaces::part(test_surfaces::sphere({0, 0, 0}, 1, 5), [](const Vec3& c) { return c[2] < 0.5; });
    const VolumeMesh result = mesh_volume(bowl, {.target_tets = 1000, .margin = 0, .thicken = false});
    expect_sound(result, 1000);
    // The ball without its cap, give or take how the winding number bridges the hole.
    const double cap = std::numbers::pi * 0.25 * (3 - 0.5) / 3;
    EXPECT_NEAR(result.report.mesh_volume, 4 * std::numbers::pi / 3 - cap, 0.3);
    EXPECT_EQ(result.report.mesh_pieces, 1u);
}

TEST(VolumeMesh, ThinEarsAreThickenedInsteadOfLost) {
    // A ball with a thin plate growing out of it, much thinner than a cell.
    SurfaceMesh shape = test_surfaces::sphere({0, 0, 0}, 0.5);
    test_surfaces::append(shape, test_surfaces::cube({-0.02, -0.2, 0.3}, {0.02, 0.2, 1.5}));
    const VolumeMesh lost = mesh_volume(shape, {.target_tets = 500, .margin = 0.1, .thicken = false});
    EXPECT_GT(lost.report.outside_distance, 0.5);
    const VolumeMesh kept = mesh_volume(shape, {.target_tets = 500});
    expect_sound(kept, 500);
    EXPECT_LT(kept.report.outside_distance, 0.6 * kept.report.cell);
    EXPECT_GT(kept.report.thickened, 0u);
    EXPECT_EQ(kept.report.mesh_pieces, 1u);
}

TEST(VolumeMesh, OnePieceForEachSeparatePart) {
    SurfaceMesh two = test_surfaces::sphere({0, 0, 0}, 0.5);
    test_surfaces::append(two, test_surfaces::sphere({3, 0, 0}, 0.3));
    const VolumeMesh result = mesh_volume(two, {.target_tets = 1500});
    EXPECT_EQ(result.report.surface_pieces, 2u);
    EXPECT_EQ(result.report.mesh_pieces, 2u);
    EXPECT_EQ(result.report.dropped_pieces, 0u);
}

TEST(VolumeMesh, SolidsThatShareAnEdgeKeepTheirVolume) {
    SurfaceMesh two = boundary_surface(box_mesh({0, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 2}));
    test_surfaces::append(two, boundary_surface(box_mesh({0.5, 0.5, 0}, {1, 1, 0.5}, {2, 2, 2})));
    repair(two);  // welds the edge
    for (int target : {400, 2000}) {
        const VolumeMesh result = mesh_volume(two, {.target_tets = target});
        EXPECT_EQ(result.report.surface_pieces, 2u);
        EXPECT_EQ(result.report.dropped_pieces, 0u);
        EXPECT_NEAR(result.report.mesh_volume, 0.25, 0.3 * 0.25) << target;
    }
}

TEST(VolumeMesh, AnOpenSheetIsCoveredByCellsOfUsefulSize) {
    SurfaceMesh sheet = test_surfaces::part(boundary_surface(box_mesh({0, 0, 0}, {1, 1, 0.3}, {12, 12, 1})), [](const Vec3& c) { return c[2] > 0.29; });
    repair(sheet);  // drops the vertices of the other faces
    for (int target : {120, 400, 2000}) {
        const VolumeMesh result = mesh_volume(sheet, {.target_tets = target});
        EXPECT_NO_THROW(validate(result.mesh));
        EXPECT_NEAR(static_cast<double>(result.report.tets), target, 0.3 * target);
        // One layer of cubes, about 12 tets each: as many over a square metre.
        EXPECT_NEAR(result.report.cell, std::sqrt(12.0 / target), 0.6 * std::sqrt(12.0 / target)) << target;
        EXPECT_LT(result.report.outside_distance, 0.3 * result.report.cell);
        EXPECT_EQ(result.report.mesh_pieces, 1u);
    }
}

TEST(VolumeMesh, CutOffEndsAreDroppedAndReported) {
    // A dumbbell with a waist far thinner than a cell.
    SurfaceMesh dumbbell = test_surfaces::sphere({0, 0, 0}, 0.5, 5);
    for (Vec3& x : dumbbell.positions) {
        const double z = 3 * x[2];
        const double waist = 0.004 + 0.996 * std::min(1.0, z * z * 1.5);
        x = Vec3(x[0] * waist, x[1] * waist, z);
    }
    dumbbell.positions[4][2] += 0.2;  // one end is larger
    const VolumeMesh result = mesh_volume(dumbbell, {.target_tets = 600, .margin = 0, .thicken = false});
    EXPECT_EQ(result.report.mesh_pieces, 1u);
    EXPECT_EQ(result.report.dropped_pieces, 1u);
    EXPECT_GT(result.report.dropped_volume, 0.2 * result.report.mesh_volume);
    EXPECT_NE(describe(result.report).find("left out"), std::string::npos);
    const VolumeMesh whole = mesh_volume(dumbbell, {.target_tets = 600});
    EXPECT_EQ(whole.report.dropped_pieces, 0u);
}

TEST(VolumeMesh, SurvivesDirtySurfaces) {
    SurfaceMesh dirty = test_surfaces::sphere({0, 0, 0}, 1, 3);
    test_surfaces::append(dirty, test_surfaces::sphere({0.7, 0, 0}, 0.8, 3));  // interpenetrating
    for (std::size_t t = 0; t < dirty.triangles.size(); t += 20) dirty.triangles.push_back(dirty.triangles[t]);
    for (std::size_t t = 0; t < dirty.triangles.size(); t += 37)
        std::swap(dirty.triangles[t][0], dirty.triangles[t][1]);
    dirty.triangles.push_back({0, 0, 1});
    const VolumeMesh result = mesh_volume(dirty, {.target_tets = 1500});
    expect_sound(result, 1500);
    EXPECT_EQ(result.report.mesh_pieces, 1u);
}

TEST(VolumeMesh, DoesNotDependOnScale) {
    const SurfaceMesh unit = test_surfaces::part(test_surfaces::torus(1, 0.4, 32, 16), [](const Vec3& c) { return c[0] < 1.2; });
    const std::size_t tets = mesh_volume(unit, {.target_tets = 400}).report.tets;
    for (double scale : {1e-6, 1e6}) {
        SurfaceMesh scaled = unit;
        for (Vec3& x : scaled.positions) x *= scale;
        const VolumeMesh result = mesh_volume(scaled, {.target_tets = 400});
        expect_sound(result, 400);
        EXPECT_NEAR(static_cast<double>(result.report.tets), static_cast<double>(tets),
                    0.2 * static_cast<double>(tets));
    }
}

TEST(VolumeMesh, IsDeterministic) {
    const VolumeMesh a = mesh_volume(test_surfaces::torus(1, 0.4), {.target_tets = 800});
    const VolumeMesh b = mesh_volume(test_surfaces::torus(1, 0.4), {.target_tets = 800});
    EXPECT_EQ(a.mesh.positions, b.mesh.positions);
    EXPECT_EQ(a.mesh.corners, b.mesh.corners);
}

TEST(VolumeMesh, RefusesWhatItCannotFill) {
    const SurfaceMesh ball = test_surfaces::sphere({0, 0, 0}, 1, 2);
    EXPECT_THROW(mesh_volume(ball, {.target_tets = 5}), InputError);
    EXPECT_THROW(mesh_volume(ball, {.margin = 2}), InputError);
    EXPECT_THROW(mesh_volume({}), InputError);
    SurfaceMesh inside_out;
    test_surfaces::append(inside_out, ball, true);
    EXPECT_THROW(mesh_volume(inside_out, {.target_tets = 100, .margin = 0, .thicken = false}), InputError);
    SurfaceMesh point = ball;
    for (Vec3& x : point.positions) x.setOnes();
    EXPECT_THROW(mesh_volume(point), InputError);
    SurfaceMesh broken = ball;
    broken.positions[3][1] = std::nan("");
    EXPECT_THROW(mesh_volume(broken), InputError);
}

}  // namespace
}  // namespace tetfront
