#include "engine/mesh/winding_number.hpp"

#include "engine/base/error.hpp"
#include "tests/engine/mesh/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::vector<Vec3> random_points(std::size_t count, double size) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-size, size);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
        points.emplace_back(x, y, z);
    }
    return points;
}

TEST(WindingNumber, CubeIsOneInsideAndZeroOutside) {
    const SurfaceBvh bvh(test_surfaces::cube({-1, -1, -1}, {1, 1, 1}));
    for (const Vec3& p : random_points(500, 2)) {
        const double depth = 1 - p.cwiseAbs().maxCoeff();
        if (std::abs(depth) < 1e-6) continue;
        EXPECT_NEAR(bvh.winding_number(p), depth > 0 ? 1 : 0, 1e-2) << p.transpose();
        EXPECT_NEAR(bvh.exact_winding_number(p), depth > 0 ? 1 : 0, 1e-12) << p.transpose();
    }
}

TEST(WindingNumber, ExpansionIsCloseToTheExactSum) {
    const SurfaceBvh bvh(test_surfaces::torus(1, 0.4, 96, 48));
    double worst = 0;
    for (const Vec3& p : random_points(500, 1.6))
        worst = std::max(worst, std::abs(bvh.winding_number(p) - bvh.exact_winding_number(p)));
    EXPECT_LT(worst, 1e-2);
    EXPECT_GT(worst, 0) << "the expansion was never used";
}

TEST(WindingNumber, FlippedSurfaceIsMinusOneAndNestedSurfacesAdd) {
    SurfaceMesh flipped;
    test_surfaces::append(flipped, test_surfaces::sphere({0, 0, 0}, 1), true);
    EXPECT_NEAR(SurfaceBvh(flipped).winding_number({0.1, 0.2, 0.3}), -1, 5e-3);
    SurfaceMesh nested = test_surfaces::sphere({0, 0, 0}, 1);
    test_surfaces::append(nested, test_surfaces::sphere({0, 0, 0}, 0.5));
    EXPECT_NEAR(SurfaceBvh(nested).winding_number({0.1, 0, 0}), 2, 3e-2);
    EXPECT_NEAR(SurfaceBvh(nested).winding_number({0.8, 0, 0}), 1, 1e-2);
}

TEST(WindingNumber, OpenHemisphereIsItsSolidAngle) {
    const SurfaceMesh bowl = test_surfaces::part(test_surfaces::sphere({0, 0, 0}, 1, 6), [](const Vec3& c) { return c[2] < 0; });
    const SurfaceBvh bvh(bowl);
    EXPECT_NEAR(bvh.winding_number({0, 0, 0}), 0.5, 2e-3);
    // From a point on the axis at height h the rim subtends the solid angle 2 pi (1 - h / sqrt(1 + h^2)).
    for (double h : {-0.6, -0.3, 0.4, 1.5}) {
        const double rim = (1 - std::abs(h) / std::sqrt(1 + h * h)) / 2;
        EXPECT_NEAR(bvh.winding_number({0, 0, h}), h < 0 ? 1 - rim : rim, 4e-3) << h;
    }
}

TEST(ClosestPoint, AgreesWithAllTriangles) {
    const SurfaceMesh mesh = test_surfaces::torus(1, 0.4, 24, 12);
    const SurfaceBvh bvh(mesh);
    for (const Vec3& p : random_points(300, 2)) {
        double best = std::numeric_limits<double>::infinity();
        for (const auto& t : mesh.triangles) {
            const auto x = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
            best = std::min(best, (closest_on_triangle(p, x(0), x(1), x(2)) - p).norm());
        }
        const SurfaceBvh::Closest found = bvh.closest(p);
        EXPECT_DOUBLE_EQ(found.distance, best);
        EXPECT_DOUBLE_EQ((found.point - p).norm(), found.distance);
        EXPECT_EQ(bvh.closest(p, best * 0.999).triangle, -1);
        EXPECT_EQ(bvh.closest(p, best * 1.001).triangle, found.triangle);
    }
}

TEST(ClosestPoint, OfATriangleIsOnItsFaceEdgesAndCorners) {
    const Vec3 a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    EXPECT_TRUE(closest_on_triangle({0.5, 0.5, 3}, a, b, c).isApprox(Vec3(0.5, 0.5, 0)));
    EXPECT_TRUE(closest_on_triangle({1, -1, 1}, a, b, c).isApprox(Vec3(1, 0, 0)));
    EXPECT_TRUE(closest_on_triangle({2, 2, 1}, a, b, c).isApprox(Vec3(1, 1, 0)));
    EXPECT_TRUE(closest_on_triangle({5, -1, 0}, a, b, c).isApprox(b));
    EXPECT_TRUE(closest_on_triangle({1, 1, 0}, a, a, b).isApprox(Vec3(1, 0, 0)));  // a segment
    EXPECT_TRUE(closest_on_triangle({1, 1, 0}, b, b, b).isApprox(b));              // a point
}

TEST(ClosestPoint, HierarchyNeedsATriangle) { EXPECT_THROW(SurfaceBvh(SurfaceMesh{}), LogicError); }

}  // namespace
}  // namespace tetfront
