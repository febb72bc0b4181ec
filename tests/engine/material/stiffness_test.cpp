#include "engine/material/stiffness.hpp"

#include "engine/base/error.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const std::array<Vec3, 4> unit_tet = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

TEST(Material, OrthotropicWithEqualConstantsIsIsotropicInEveryFrame) {
    const double young = 2e5, poisson = 0.3, shear = young / (2 * (1 + poisson));
    const Mat3 frame = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    const Sym6 c = orthotropic({.young = Vec3::Constant(young),
                                .poisson = Vec3::Constant(poisson),
                                .shear = Vec3::Constant(shear),
                                .frame = frame});
    EXPECT_LT((c.matrix() - isotropic(young, poisson).matrix()).norm(), 1e-12 * c.matrix().norm());
}

TEST(Material, OrthotropicFollowsItsFrame) {
    // Fibres along x, turned to z: pulling along z is now the stiff direction.
    Mat3 frame;
    frame << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // first axis of the material is z
    const Orthotropic fibres{
        .young = {1e6, 1e4, 1e4}, .poisson = {0.3, 0.3, 0.3}, .shear = {4e3, 5e3, 5e3}, .frame = frame};
    const Mat6 compliance = orthotropic(fibres).matrix().inverse();
    EXPECT_NEAR(1 / compliance(2, 2), 1e6, 1e-3);
    EXPECT_NEAR(1 / compliance(0, 0), 1e4, 1e-5);
    EXPECT_NEAR(1 / compliance(3, 3), 5e3, 1e-5);
    EXPECT_NEAR(1 / compliance(5, 5), 4e3, 1e-5);
    EXPECT_NEAR(-compliance(0, 2) / compliance(2, 2), 0.3, 1e-12);
}

TEST(Material, RefusesConstantsOutOfRange) {
    EXPECT_THROW(isotropic(-1, 0.3), InputError);
    EXPECT_THROW(isotropic(nan, 0.3), InputError);
    EXPECT_THROW(isotropic(1e5, 0.5), InputError);
    EXPECT_THROW(orthotropic({.young = {1, 1, -1}}), InputError);
    EXPECT_THROW(orthotropic({.frame = 2 * Mat3::Identity()}), InputError);
    EXPECT_THROW(orthotropic({.young = {1, 1, 1}, .poisson = {0.9, 0.9, 0.9}}), InputError);
    EXPECT_THROW(gradient(0, {1, 1}, {1, 2}, Interpolation::linear), InputError);
    EXPECT_THROW(gradient(0, {0, 1}, {1, -2}, Interpolation::exponential), InputError);
}

TEST(Material, RepresentativeYoungIsExactForIsotropic) {
    EXPECT_NEAR(representative_young(isotropic(1.7e5, 0.4)), 1.7e5, 1e-6);
}

TEST(Stiffness, ConstantFunctionGivesExactlyItsMaterial) {
    const StiffnessFunction f({.young = constant(3e5), .poisson = constant(0.2), .density = constant(1234)});
    const Material m = mean_material(f, unit_tet, TetId{0});
    EXPECT_EQ(m.elasticity, isotropic(3e5, 0.2));
    EXPECT_EQ(m.density, 1234);
}

TEST(Stiffness, LinearGradientHasTheCentroidAsItsMean) {
    const StiffnessFunction f({.young = gradient(0, {0, 1}, {1e4, 1e6}, Interpolation::linear),
                               .density = gradient(2, {0, 1}, {1000, 2000}, Interpolation::linear)});
    const Material m = mean_material(f, unit_tet, TetId{0});
    EXPECT_NEAR(representative_young(m.elasticity), 1e4 + 0.25 * (1e6 - 1e4), 1e-6);
    EXPECT_NEAR(m.density, 1250, 1e-9);
}

TEST(Stiffness, ExponentialGradientIsIntegrated) {
    // Over the unit tet, integral of exp(a x) times 3 (1 - x)^2 for x in 0..1.
    const double a = std::log(100.0), mean = 6 / (a * a * a) * (std::exp(a) - 1 - a - a * a / 2);
    const StiffnessFunction f({.young = gradient(0, {0, 1}, {1e4, 1e6}, Interpolation::exponential)});
    EXPECT_NEAR(representative_young(mean_material(f, unit_tet, TetId{0}).elasticity), 1e4 * mean, 1e-3 * 1e4 * mean);
}

TEST(Stiffness, DampingIsWeightedByMassAndStiffness) {
    const StiffnessFunction f({.young = gradient(0, {0, 1}, {1e4, 1e6}, Interpolation::linear),
                               .density = gradient(0, {0, 1}, {1, 3}, Interpolation::linear),
                               .mass_damping = gradient(0, {0, 1}, {0, 2}, Interpolation::linear),
                               .stiffness_damping = constant(0.01)});
    const Material m = mean_material(f, unit_tet, TetId{0});
    // <x> = 1/4, <x^2> = 1/10: <(1 + 2x) 2x> / <1 + 2x> = (0.5 + 0.4) / 1.5
    EXPECT_NEAR(m.mass_damping, 0.6, 1e-4);
    EXPECT_NEAR(m.stiffness_damping, 0.01, 1e-12);
}

TEST(Stiffness, SaysWhereAConstantIsOutOfRange) {
    const StiffnessFunction f({.young = gradient(0, {0, 1}, {1e4, -1e6}, Interpolation::linear)});
    try {
        mean_material(f, unit_tet, TetId{0});
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("Young's modulus at ("), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace tetfront
