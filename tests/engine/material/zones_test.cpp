#include "engine/material/zones.hpp"

#include "engine/base/error.hpp"
#include "engine/material/stiffness.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

const std::array<Vec3, 4> unit_tet = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
const TetId root{0};

TEST(Zones, LayersIncludeTheirLowerBoundary) {
    const Zones z = layers(2, {1, 2});
    EXPECT_EQ(z->zone({0, 0, 0.99}, root), 0);
    EXPECT_EQ(z->zone({0, 0, 1}, root), 1);
    EXPECT_EQ(z->zone({0, 0, 5}, root), 2);
    EXPECT_TRUE(z->one_zone_within({Vec3(0, 0, 1.1), Vec3(9, 9, 1.9)}, root));
    EXPECT_FALSE(z->one_zone_within({Vec3(0, 0, 0.9), Vec3(9, 9, 1.1)}, root));
    EXPECT_THROW(layers(0, {1, 1}), InputError);
}

TEST(Zones, HighestPriorityWinsAndLaterOfEquals) {
    const Zones z = shapes({{Sphere{{0, 0, 0}, 1}, 1, 5},
                            {Box{{-2, -2, -2}, {2, 2, 2}}, 2, 0},
                            {HalfSpace{{0, 0, 0}, {1, 0, 0}}, 3, 0}},
                           7);
    EXPECT_EQ(z->zone({0.5, 0, 0}, root), 1);
    EXPECT_EQ(z->zone({-0.5, 0, 0}, root), 1);
    EXPECT_EQ(z->zone({1.5, 0, 0}, root), 2);
    EXPECT_EQ(z->zone({-1.5, 0, 0}, root), 3);
    EXPECT_EQ(z->zone({5, 0, 0}, root), 7);
    EXPECT_TRUE(z->one_zone_within({Vec3(-0.1, -0.1, -0.1), Vec3(0.1, 0.1, 0.1)}, root));
    EXPECT_FALSE(z->one_zone_within({Vec3(0.8, 0, 0), Vec3(1.2, 0.1, 0.1)}, root));
    EXPECT_TRUE(z->one_zone_within({Vec3(5, 5, 5), Vec3(6, 6, 6)}, root));
    EXPECT_THROW(shapes({{Sphere{{0, 0, 0}, -1}}}, 0), InputError);
    EXPECT_THROW(shapes({{HalfSpace{{0, 0, 0}, {0, 0, 0}}}}, 0), InputError);
    EXPECT_THROW(shapes({{Box{{0, 0, 0}, {1, 0, 1}}}}, 0), InputError);
}

TEST(Zones, OneZoneWithinIsNeverWrong) {
    const Zones z =
        shapes({{Sphere{{0.3, 0.2, 0.1}, 0.6}, 1, 1}, {HalfSpace{{0, 0, 0}, {1, 1, -1}}, 2, 0}}, 0);
    srand(1);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 a = Vec3::Random(), b = a + 0.3 * (Vec3::Random() + Vec3::Ones());
        const Eigen::AlignedBox3d box(a, b);
        if (!z->one_zone_within(box, root)) continue;
        for (int j = 0; j < 8; ++j) EXPECT_EQ(z->zone(box.sample(), root), z->zone(a, root));
    }
}

TEST(Zones, LeafThatAJumpCutsGetsTheVolumeShares) {
    // The plane x = 0.3 cuts off 0.7^3 of the unit tet.
    const StiffnessFunction f(layers(0, {0.3}), {{.young = constant(1e4), .density = constant(1000)},
                                                 {.young = constant(1e6), .density = constant(2000)}});
    const Material m = mean_material(f, unit_tet, root);
    const double share = 0.343;
    EXPECT_NEAR(m.density, 1000 + 1000 * share, 5);
    EXPECT_NEAR(representative_young(m.elasticity), 1e4 + (1e6 - 1e4) * share, 0.005 * 1e6);
}

TEST(Zones, ThinLayerThatTheCornersMissIsSeen) {
    const StiffnessFunction f(layers(2, {0.3, 0.36}),
                              {{.young = constant(1e4)}, {.young = constant(1e6)}, {.young = constant(1e4)}});
    const double share = 0.7 * 0.7 * 0.7 - 0.64 * 0.64 * 0.64;
    EXPECT_NEAR(representative_young(mean_material(f, unit_tet, root).elasticity), 1e4 + (1e6 - 1e4) * share,
                0.02 * 1e6);
}

TEST(Zones, UniformLeavesOfAZoneAreExact) {
    const StiffnessFunction f(layers(0, {2}), {{.young = constant(1e4)}, {.young = constant(1e6)}});
    EXPECT_EQ(mean_material(f, unit_tet, root).elasticity, isotropic(1e4, 0.3));
}

TEST(Zones, PerRootValuesAndZones) {
    const StiffnessFunction by_zone(root_zones({0, 1}), {{.young = constant(1e4)}, {.young = constant(1e6)}});
    EXPECT_EQ(mean_material(by_zone, unit_tet, TetId{1}).elasticity, isotropic(1e6, 0.3));
    EXPECT_THROW(mean_material(by_zone, unit_tet, TetId{2}), InputError);
    const StiffnessFunction by_value({.young = per_root({3e4, 5e4})});
    EXPECT_EQ(mean_material(by_value, unit_tet, TetId{1}).elasticity, isotropic(5e4, 0.3));
    EXPECT_THROW(mean_material(by_value, unit_tet, TetId{2}), InputError);
}

TEST(Zones, ZoneWithoutMaterialIsNamed) {
    const StiffnessFunction f(layers(0, {0.1}), {{.young = constant(1e4)}});
    try {
        mean_material(f, unit_tet, root);
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("zone 1"), std::string::npos) << e.what();
    }
}

TEST(Zones, OrthotropicZoneKeepsItsFrame) {
    Orthotropic fibres{.young = {1e6, 1e4, 1e4}, .poisson = {0.3, 0.3, 0.3}, .shear = {4e3, 5e3, 5e3}};
    MaterialFunction material;
    material.orthotropic = fibres;
    material.scale = gradient(0, {0, 1}, {1, 3}, Interpolation::linear);
    const Mat6 c = mean_material(StiffnessFunction(material), unit_tet, root).elasticity.matrix();
    EXPECT_LT((c - 1.5 * orthotropic(fibres).matrix()).norm(), 1e-9 * c.norm());
}

}  // namespace
}  // namespace tetfront
