#include "engine/mechanics/svd3.hpp"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "engine/base/types.hpp"

namespace tetfront {
namespace {

Mat3 matrix(const M3<double>& m) { return (Mat3() << m.m[0], m.m[1], m.m[2], m.m[3], m.m[4], m.m[5], m.m[6], m.m[7], m.m[8]).finished(); }
M3<double> from(const Mat3& f) {
    M3<double> m;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) m(r, c) = f(r, c);
    return m;
}

void check(const Mat3& f) {
    SCOPED_TRACE(::testing::PrintToString(f));
    const Svd3<double> d = svd3(from(f));
    const Mat3 u = matrix(d.u), v = matrix(d.v);
    const Vec3 s(d.s[0], d.s[1], d.s[2]);
    const double scale = std::max(1e-300, f.norm());
    EXPECT_TRUE(u.allFinite() && v.allFinite() && s.allFinite());
    EXPECT_LT((u.transpose() * u - Mat3::Identity()).norm(), 1e-13);
    EXPECT_LT((v.transpose() * v - Mat3::Identity()).norm(), 1e-13);
    EXPECT_NEAR(u.determinant(), 1, 1e-13);
    EXPECT_NEAR(v.determinant(), 1, 1e-13);
    EXPECT_LT((u * s.asDiagonal() * v.transpose() - f).norm(), 2e-8 * scale) << "F = U S V^T";
    EXPECT_GE(s[0], 0);
    EXPECT_GE(s[1], -1e-8 * scale);
    EXPECT_GE(s[1] + 1e-8 * scale, std::abs(s[2]));
}

TEST(Svd3, HoldsForEveryKindOfMatrix) {
    std::mt19937 random(1);
    std::normal_distribution<double> n;
    for (int i = 0; i < 2000; ++i) check(Mat3::NullaryExpr([&] { return n(random); }));
    for (int i = 0; i < 200; ++i) {
        const Vec3 a(n(random), n(random), n(random)), b(n(random), n(random), n(random));
        check(a * b.transpose());                                        // rank one
        check(a * b.transpose() + Vec3(b.cross(a)) * a.transpose());     // rank two
        check(1e-30 * Mat3::NullaryExpr([&] { return n(random); }));
        check(1e20 * Mat3::NullaryExpr([&] { return n(random); }));
    }
    check(Mat3::Zero());
    check(Mat3::Identity());
    check(-Mat3::Identity());
    check(Vec3(1, 1, -1).asDiagonal());
    check(Vec3(0, 0, 5).asDiagonal());
    check(Vec3(1e-12, 1, 1e6).asDiagonal());
}

TEST(Svd3, IsAccurateForWellConditionedMatrices) {
    std::mt19937 random(2);
    std::normal_distribution<double> n;
    for (int i = 0; i < 500; ++i) {
        const Mat3 f = Mat3::Identity() + 0.3 * Mat3::NullaryExpr([&] { return n(random); });
        const Svd3<double> d = svd3(from(f));
        const Vec3 s(d.s[0], d.s[1], d.s[2]);
        const Vec3 expected = Eigen::JacobiSVD<Mat3>(f).singularValues();
        EXPECT_NEAR(s[0], expected[0], 1e-13);
        EXPECT_NEAR(std::abs(s[2]), expected[2], 1e-11);
        EXPECT_EQ(s[2] < 0, f.determinant() < 0);
    }
}

TEST(Svd3, PacksAgreeWithScalars) {
    std::mt19937 random(3);
    std::normal_distribution<double> n;
    std::array<Mat3, pack_size> f;
    M3<Pack> packed;
    for (auto& m : f) m = Mat3::NullaryExpr([&] { return n(random); });
    f[0].setZero();
    for (std::size_t k = 0; k < 9; ++k) packed.m[k] = Pack([&](std::size_t lane) { return f[lane](static_cast<int>(k / 3), static_cast<int>(k % 3)); });
    const Svd3<Pack> d = svd3(packed);
    for (std::size_t lane = 0; lane < pack_size; ++lane) {
        const Svd3<double> one = svd3(from(f[lane]));
        for (std::size_t k = 0; k < 9; ++k) {
            EXPECT_NEAR(static_cast<double>(d.u.m[k][lane]), one.u.m[k], 1e-14);
            EXPECT_NEAR(static_cast<double>(d.v.m[k][lane]), one.v.m[k], 1e-14);
        }
    }
}

}  // namespace
}  // namespace tetfront
