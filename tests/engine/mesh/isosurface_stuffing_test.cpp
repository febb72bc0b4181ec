#include "engine/mesh/isosurface_stuffing.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/tet_repair.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

struct Summary {
    double volume = 0;
    std::array<double, 2> dihedral = {180, 0};
};
Summary summarize(const TetMesh& mesh) {
    Summary s;
    for (const auto& c : mesh.corners) {
        const auto x = [&](std::size_t i) { return mesh.positions[c[i]]; };
        s.volume += signed_volume(x(0), x(1), x(2), x(3));
        const auto [low, high] = dihedral_range(x(0), x(1), x(2), x(3));
        s.dihedral = {std::min(s.dihedral[0], low), std::max(s.dihedral[1], high)};
    }
    return s;
}

bool in_torus(const Vec3& p) {
    const double ring = std::hypot(p[0], p[1]) - 1;
    return ring * ring + p[2] * p[2] < 0.16;
}
bool in_ball(const Vec3& p) { return p.norm() < 1; }

template <class Shape>
void expect_second_order(const Shape& inside, double exact) {
    // The error varies with how the lattice happens to lie: compare over a factor of four.
    double coarse = 0, fine = 0;
    for (double shift : {0.0, 0.3, 0.7}) {
        const Vec3 low(-1.5, -1.5, -1.5), high(1.5 + shift, 1.5, 1.5);
        coarse += std::abs(summarize(stuff_isosurface(low, high, 0.24, inside)).volume / exact - 1);
        fine += std::abs(summarize(stuff_isosurface(low, high, 0.06, inside)).volume / exact - 1);
    }
    const double rate = std::log2(coarse / fine) / 2;
    EXPECT_GT(rate, 1.6);
    EXPECT_LT(rate, 2.4);
}

TEST(IsosurfaceStuffing, VolumeOfABallConvergesWithSecondOrder) {
    expect_second_order(in_ball, 4 * std::numbers::pi / 3);
}
TEST(IsosurfaceStuffing, VolumeOfATorusConvergesWithSecondOrder) {
    expect_second_order(in_torus, 2 * std::numbers::pi * std::numbers::pi * 0.16);
}

TEST(IsosurfaceStuffing, AnglesKeepTheirBoundsForAnyShape) {
    double smallest = 180, largest = 0;
    for (int seed = 0; seed < 25; ++seed) {
        const double f = 2 + 0.9 * seed;
        const TetMesh mesh = stuff_isosurface({-1, -1, -1}, {1, 1, 1}, 0.17, [&](const Vec3& p) {
            return std::sin(f * p[0] + seed) + std::sin(1.3 * f * p[1] - p[0] * f) +
                           std::sin(0.8 * f * p[2] + 2 * p[1] + seed * 3) >
                       0.3 &&
                   p.norm() < 1;
        });
        const Summary s = summarize(mesh);
        smallest = std::min(smallest, s.dihedral[0]);
        largest = std::max(largest, s.dihedral[1]);
        TetMesh separated = mesh;
        separate_pinches(separated);
        EXPECT_NO_THROW(validate(separated));
    }
    EXPECT_GT(smallest, stuffing_min_dihedral);
    EXPECT_LT(largest, stuffing_max_dihedral);
    EXPECT_LT(smallest, 15) << "the shapes do not test the bound";
}

TEST(IsosurfaceStuffing, SmoothShapesConformAndAreOnePiece) {
    for (double cell : {0.4, 0.23, 0.11}) {
        TetMesh mesh = stuff_isosurface({-1.4, -1.4, -0.4}, {1.4, 1.4, 0.4}, cell, in_torus);
        EXPECT_NO_THROW(validate(mesh));
        const SurfaceMesh skin = boundary_surface(mesh);
        // A torus: V - E + F = 0 with E = 3F/2.
        EXPECT_EQ(2 * skin.positions.size(), skin.triangles.size()) << cell;
        EXPECT_EQ(separate_pinches(mesh), 0u);
        EXPECT_EQ(count_pinched_edges(mesh), 0u);
        for (std::int32_t piece : connected_pieces(mesh)) EXPECT_EQ(piece, 0);
    }
}

TEST(IsosurfaceStuffing, EmptyShapeGivesNoTetsAndHugeLatticesAreRefused) {
    EXPECT_TRUE(stuff_isosurface({0, 0, 0}, {1, 1, 1}, 0.2, [](const Vec3&) { return false; }).corners.empty());
    EXPECT_THROW(stuff_isosurface({0, 0, 0}, {1, 1, 1}, 1e-3, in_ball), InputError);
}

}  // namespace
}  // namespace tetfront
