// The contact of a point with the ground: its force and tangent are derivatives of its potential.

#include <gtest/gtest.h>

#include <random>

#include <Eigen/Eigenvalues>

#include "engine/mechanics/contact.hpp"
#include "tests/support/fronts.hpp"

namespace tetfront {
namespace {

constexpr double h = 0.01;
const Vec3 normal = Vec3(0.6, 0, 0.8);

PointContact contact() { return {{}, normal, 1, 500, 0.1, 0.4, 20, 0.05}; }

/// Deep and shallow, in the air; creeping and sliding. The velocity moves x: x = base + h v.
struct Case {
    Vec3 base, v;
};
std::vector<Case> cases() {
    std::mt19937 random(3);
    std::vector<Case> all;
    for (double depth : {0.3, 0.01, -0.2})
        for (double speed : {0.01, 1.0})
            all.push_back({(1 - depth) * normal + Vec3(-0.8, 1, 0.6), speed * testing::random_vector(random).normalized()});
    return all;
}

TEST(Contact, ForceIsTheDerivativeOfThePotential) {
    for (const auto& [base, v] : cases()) {
        const PointContact c = contact();
        const Vec3 force = c.force(base + h * v, v);
        for (int axis = 0; axis < 3; ++axis) {
            const double e = 1e-6;
            const Vec3 up = v + e * Vec3::Unit(axis), down = v - e * Vec3::Unit(axis);
            const double slope = (c.potential(base + h * up, up, h) - c.potential(base + h * down, down, h)) / (2 * e);
            EXPECT_NEAR(slope, -h * force[axis], 1e-6 * std::max(1.0, force.norm())) << base.transpose() << " / " << v.transpose();
        }
    }
}

TEST(Contact, TangentIsTheDerivativeOfTheForceAndPositive) {
    for (const auto& [base, v] : cases()) {
        const PointContact c = contact();
        const Mat3 tangent = c.tangent(base + h * v, v, h);
        for (int axis = 0; axis < 3; ++axis) {
            const double e = 1e-6;
            const Vec3 up = v + e * Vec3::Unit(axis), down = v - e * Vec3::Unit(axis);
            const Vec3 slope = -h * (c.force(base + h * up, up) - c.force(base + h * down, down)) / (2 * e);
            EXPECT_LT((slope - tangent.col(axis)).norm(), 1e-6 * std::max(1.0, tangent.norm()));
        }
        EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(tangent).eigenvalues().minCoeff(), -1e-12);
    }
}

TEST(Contact, PushesOutAndOpposesSliding) {
    const PointContact c = contact();
    const Vec3 along(0.8, 0, -0.6);
    const Vec3 force = c.force(0.9 * normal, 3 * along);
    EXPECT_NEAR(force.dot(normal), 500 * 0.1 * 2, 1e-12);
    EXPECT_NEAR(force.dot(along), -0.4 * 20, 1e-12);
    EXPECT_EQ(c.force(1.1 * normal, Vec3::Zero()).norm(), 0);
}

}  // namespace
}  // namespace tetfront
