// Energy, force and tangent of whole fronts: Taylor tests, patch tests, conservation.
#include "engine/mechanics/elements.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "engine/mechanics/block_matrix.hpp"
#include "tests/support/fronts.hpp"

namespace tetfront {
namespace {

using testing::random_vector;
using testing::shuffle;

/// A front with everything that forces need.
struct Body {
    Body(const TetTree& tree_, Front front_, const Mat6& c, StrainMeasure measure)
        : tree(tree_), front(std::move(front_)), elasticity(tree.tet_count(), Sym6::from(c)), density(tree.tet_count(), 1000.0) {
        elements.set_strain_measure(measure);
        elements.build(front, {elasticity, density});
        x = tree.rest();
    }
    PerVertex<Vec3> force(const PerVertex<Vec3>& at) {
        elements.evaluate({.x = at});
        PerVertex<Vec3> f(tree.vertex_count(), Vec3::Zero());
        elements.accumulate(f);
        front.restrict_to_free(f);
        return f;
    }
    double energy(const PerVertex<Vec3>& at) {
        elements.evaluate({.x = at});
        return elements.energy();
    }
    PerVertex<Vec3> random_field(std::mt19937& random, double scale) {
        PerVertex<Vec3> u(tree.vertex_count(), Vec3::Zero());
        for (VertexId v : front.vertices()) u[v] = scale * random_vector(random);
        front.prolong(u);
        return u;
    }
    PerVertex<Vec3> plus(const PerVertex<Vec3>& a, double t, const PerVertex<Vec3>& b) const {
        PerVertex<Vec3> sum = a;
        for (VertexId v : front.vertices()) sum[v] += t * b[v];
        return sum;
    }
    double dot(const PerVertex<Vec3>& a, const PerVertex<Vec3>& b) const {
        double sum = 0;
        for (VertexId v : front.vertices())
            if (front.state(v) == VertexState::free) sum += a[v].dot(b[v]);
        return sum;
    }
    const TetTree& tree;
    Front front;
    PooledPerTet<Sym6> elasticity;
    PerTet<double> density;
    ElementSet elements;
    PerVertex<Vec3> x;
};

/// Symmetric positive definite without any symmetry of the material.
Mat6 anisotropic(std::mt19937& random) {
    std::normal_distribution<double> n;
    const Mat6 a = Mat6::NullaryExpr([&] { return 0.3 * n(random); });
    return 1e5 * (isotropic_elasticity(1, 0.3) + a * a.transpose());
}

class ElementsOfOrder : public ::testing::TestWithParam<std::tuple<int, StrainMeasure>> {
 protected:
    TetTree tree{box_mesh({0, 0, 0}, {2, 1, 1}, {4, 2, 2}), 3};
    std::mt19937 random{order() * 101U};
    static int order() { return std::get<0>(GetParam()); }
    static StrainMeasure measure() { return std::get<1>(GetParam()); }
    Front mixed() {
        Front front(tree, order(), 0, 99);
        shuffle(front, random, 1, 0.6, 0);
        shuffle(front, random, 3, 0.08, 0.05);
        return front;
    }
};
INSTANTIATE_TEST_SUITE_P(Orders, ElementsOfOrder,
                         ::testing::Combine(::testing::Values(1, 2), ::testing::Values(StrainMeasure::corotated, StrainMeasure::green)),
                         [](const auto& test) {
                             return std::to_string(std::get<0>(test.param)) +
                                    (std::get<1>(test.param) == StrainMeasure::green ? "Green" : "Corotated");
                         });

TEST_P(ElementsOfOrder, ForceIsMinusTheDerivativeOfTheEnergy) {
    Body body(tree, mixed(), anisotropic(random), measure());
    // Strains up to about a third, arbitrary rotation; step sizes whose Taylor remainder falls with the square.
    const PerVertex<Vec3> u = body.random_field(random, 0.004), d = body.random_field(random, 0.004);
    const Mat3 r = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    PerVertex<Vec3> at = body.plus(body.x, 1, u);
    for (VertexId v : body.front.vertices()) at[v] = r * at[v];
    const double e0 = body.energy(at);
    const double slope = -body.dot(body.force(at), d);
    std::array<double, 3> remainder{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double t = 0.02 / static_cast<double>(1 << k);
        remainder[k] = std::abs(body.energy(body.plus(at, t, d)) - e0 - t * slope);
    }
    EXPECT_NEAR(std::log2(remainder[0] / remainder[1]), 2, 0.05);
    EXPECT_NEAR(std::log2(remainder[1] / remainder[2]), 2, 0.05);
}

/// -D v with the D that the tangent has: both come from the coefficients of every tet.
TEST_P(ElementsOfOrder, DampingForceIsTheTangentsDampingTimesVelocity) {
    Body body(tree, mixed(), anisotropic(random), measure());
    std::uniform_real_distribution<double> uniform(0, 1);
    PerTet<double> mass_damping(tree.tet_count()), stiffness_damping(tree.tet_count());
    for (double& a : mass_damping) a = uniform(random);
    for (double& b : stiffness_damping) b = 1e-3 * uniform(random);
    body.elements.build(body.front, {body.elasticity, body.density, mass_damping, stiffness_damping});
    const PerVertex<Vec3> v = body.random_field(random, 1);
    // Turned only: where there is strain the tangent leaves its second derivatives out.
    PerVertex<Vec3> at = body.x;
    const Mat3 r = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    for (VertexId w : body.front.vertices()) at[w] = r * at[w];
    const auto force = [&](const PerVertex<Vec3>* velocity) {
        body.elements.evaluate({.x = at, .force_scale = 0.5, .velocity = velocity, .tangent = true, .damping_scale = 0.5});
        PerVertex<Vec3> f(tree.vertex_count(), Vec3::Zero());
        body.elements.accumulate(f);
        body.front.restrict_to_free(f);
        return f;
    };
    const PerVertex<Vec3> elastic = force(nullptr), damped = force(&v);
    BlockMatrix d;
    d.build(body.front, body.elements, PerVertex<std::uint8_t>(tree.vertex_count(), 0));
    d.fill(body.elements);
    DofVector speed(d.size()), product(d.size());
    for (std::size_t i = 0; i < d.size(); ++i) speed[i] = v[d.vertices()[i]];
    d.multiply(speed, product);
    double error = 0, scale = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
        error = std::max(error, (damped[d.vertices()[i]] - elastic[d.vertices()[i]] + product[i]).norm());
        scale = std::max(scale, product[i].norm());
    }
    EXPECT_GT(scale, 0);
    EXPECT_LT(error, 1e-5 * scale);  // the matrix holds floats
}

TEST_P(ElementsOfOrder, InternalForcesHaveNoResultantAndNoTorque) {
    Body body(tree, mixed(), anisotropic(random), measure());
    const PerVertex<Vec3> at = body.plus(body.x, 1, body.random_field(random, 0.2));  // also inverted tets
    const PerVertex<Vec3> f = body.force(at);
    EXPECT_GT(body.elements.inverted(), 0);
    Vec3 resultant = Vec3::Zero(), torque = Vec3::Zero();
    double scale = 0;
    for (VertexId v : body.front.vertices()) {
        resultant += f[v];
        torque += at[v].cross(f[v]);
        scale += f[v].norm();
    }
    EXPECT_LT(resultant.norm(), 1e-12 * scale);
    EXPECT_LT(torque.norm(), 1e-12 * scale);
}

TEST_P(ElementsOfOrder, PatchTestOnMixedFronts) {
    // Any affine displacement of a uniform material leaves interior free vertices without force.
    for (int trial = 0; trial < 4; ++trial) {
        Body body(tree, mixed(), anisotropic(random), measure());
        ASSERT_GT(body.front.hanging().size(), 10U);
        Mat3 f = Mat3::Identity();
        for (int k = 0; k < 9; ++k) f(k / 3, k % 3) += 0.2 * random_vector(random)[0];
        const Mat3 turn = Eigen::AngleAxisd(0.7 * trial, Vec3(1, -1, 2).normalized()).toRotationMatrix();
        PerVertex<Vec3> at = body.x;
        for (VertexId v : body.front.vertices()) at[v] = turn * f * at[v];
        const PerVertex<Vec3> force = body.force(at);
        double largest = 0, interior = 0;
        int interior_count = 0;
        for (VertexId v : body.front.vertices()) {
            largest = std::max(largest, force[v].norm());
            const Vec3& p = tree.rest(v);
            const bool inside = (p.array() > 1e-9).all() && p[0] < 2 - 1e-9 && p[1] < 1 - 1e-9 && p[2] < 1 - 1e-9;
            if (!inside || body.front.state(v) != VertexState::free) continue;
            ++interior_count;
            interior = std::max(interior, force[v].norm());
        }
        EXPECT_GE(interior_count, 3);
        EXPECT_LT(interior, 1e-10 * largest);
    }
}

TEST_P(ElementsOfOrder, TangentAtRestIsTheDerivativeOfTheForce) {
    Body body(tree, mixed(), anisotropic(random), measure());
    body.elements.evaluate({.x = body.x, .tangent = true, .stiffness_scale = 1});
    BlockMatrix matrix;
    const PerVertex<std::uint8_t> nothing(tree.vertex_count(), 0);
    matrix.build(body.front, body.elements, nothing);
    matrix.fill(body.elements);
    const PerVertex<Vec3> d = body.random_field(random, 1);
    const double t = 1e-6;
    const PerVertex<Vec3> forward = body.force(body.plus(body.x, t, d)), backward = body.force(body.plus(body.x, -t, d));
    DofVector p(matrix.size()), q(matrix.size());
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = d[matrix.vertices()[i]];
    matrix.multiply(p, q);
    double error = 0, scale = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const VertexId v = matrix.vertices()[i];
        error = std::max(error, (q[i] + (forward[v] - backward[v]) / (2 * t)).norm());
        scale = std::max(scale, q[i].norm());
    }
    EXPECT_LT(error, 2e-6 * scale);  // the matrix holds floats
}

/// Nothing is compressed, so nothing of the geometric stiffness is left out.
TEST_P(ElementsOfOrder, GreenTangentInTensionIsTheDerivativeOfTheForce) {
    if (measure() != StrainMeasure::green) GTEST_SKIP() << "the corotated tangent leaves the derivative of the rotation out";
    Body body(tree, mixed(), anisotropic(random), measure());
    const Mat3 turn = Eigen::AngleAxisd(0.9, Vec3(1, 2, -1).normalized()).toRotationMatrix() * Vec3(1.3, 1.4, 1.25).asDiagonal();
    PerVertex<Vec3> at = body.plus(body.x, 1, body.random_field(random, 1e-4));
    for (VertexId v : body.front.vertices()) at[v] = turn * at[v];
    body.elements.evaluate({.x = at, .tangent = true, .stiffness_scale = 1});
    BlockMatrix matrix;
    matrix.build(body.front, body.elements, PerVertex<std::uint8_t>(tree.vertex_count(), 0));
    matrix.fill(body.elements);
    const PerVertex<Vec3> d = body.random_field(random, 1);
    const double t = 1e-6;
    const PerVertex<Vec3> forward = body.force(body.plus(at, t, d)), backward = body.force(body.plus(at, -t, d));
    DofVector p(matrix.size()), q(matrix.size());
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = d[matrix.vertices()[i]];
    matrix.multiply(p, q);
    double error = 0, scale = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const VertexId v = matrix.vertices()[i];
        error = std::max(error, (q[i] + (forward[v] - backward[v]) / (2 * t)).norm());
        scale = std::max(scale, q[i].norm());
    }
    EXPECT_LT(error, 2e-6 * scale);  // the matrix holds floats
}

TEST_P(ElementsOfOrder, TangentIsSymmetricAndPositive) {
    Body body(tree, mixed(), anisotropic(random), measure());
    const PerVertex<Vec3> at = body.plus(body.x, 1, body.random_field(random, 0.05));
    body.elements.evaluate({.x = at, .tangent = true, .stiffness_scale = 1, .mass_scale = 10});
    BlockMatrix matrix;
    const PerVertex<std::uint8_t> nothing(tree.vertex_count(), 0);
    matrix.build(body.front, body.elements, nothing);
    matrix.fill(body.elements);
    for (int trial = 0; trial < 10; ++trial) {
        DofVector a(matrix.size()), b(matrix.size()), ka(matrix.size()), kb(matrix.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            a[i] = random_vector(random);
            b[i] = random_vector(random);
        }
        matrix.multiply(a, ka);
        matrix.multiply(b, kb);
        double akb = 0, bka = 0, aka = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            akb += a[i].dot(kb[i]);
            bka += b[i].dot(ka[i]);
            aka += a[i].dot(ka[i]);
        }
        EXPECT_GT(aka, 0);
        EXPECT_NEAR(akb, bka, 1e-9 * aka);
    }
}

TEST_P(ElementsOfOrder, MassAndMomentumOfRigidMotion) {
    Body body(tree, mixed(), isotropic_elasticity(1e5, 0.3), measure());
    EXPECT_NEAR(body.elements.mass(), 2000, 1e-9);
    const Vec3 velocity(1, 2, 3), spin(0.3, -0.2, 0.5), centre(1, 0.5, 0.5);
    PerVertex<Vec3> v(tree.vertex_count(), Vec3::Zero());
    for (VertexId i : body.front.vertices()) v[i] = velocity + spin.cross(Vec3(tree.rest(i) - centre));
    const auto p = body.elements.momentum(tree.rest(), v);
    EXPECT_LT((p.linear - 2000 * velocity).norm(), 1e-8);
    // Inertia of a 2 x 1 x 1 box of 2000 kg.
    const Vec3 inertia = 2000.0 / 12 * Vec3(2, 5, 5);
    EXPECT_LT((p.angular - centre.cross(p.linear) - inertia.cwiseProduct(spin)).norm(), 1e-7);
    EXPECT_LT((body.elements.first_moment(tree.rest()) - 2000 * centre).norm(), 1e-8);
    EXPECT_LT((body.elements.first_moment(v) - p.linear).norm(), 1e-8);
    EXPECT_NEAR(body.elements.kinetic_energy(v), 0.5 * 2000 * velocity.squaredNorm() + 0.5 * spin.dot(inertia.cwiseProduct(spin)), 1e-8);
}

TEST_P(ElementsOfOrder, FlatInvertedAndCollapsedTetsGiveFiniteForces) {
    Body body(tree, mixed(), isotropic_elasticity(1e5, 0.49), measure());
    PerVertex<Vec3> at = body.x;
    const auto all_finite = [&](const PerVertex<Vec3>& f) {
        for (VertexId v : body.front.vertices())
            if (!f[v].allFinite()) return false;
        return true;
    };
    for (VertexId v : body.front.vertices()) at[v][2] = 0;
    EXPECT_TRUE(all_finite(body.force(at)));
    for (VertexId v : body.front.vertices()) at[v] = -tree.rest(v);
    EXPECT_TRUE(all_finite(body.force(at)));
    for (VertexId v : body.front.vertices()) at[v].setZero();
    EXPECT_TRUE(all_finite(body.force(at)));
    EXPECT_EQ(body.elements.inverted(), static_cast<int>(body.elements.size()));
}

TEST(ElementSet, SinglePrecisionForcesAgreeAndSumToZero) {
    std::mt19937 random(11);
    const TetTree tree(box_mesh({0, 0, 0}, {2, 1, 1}, {2, 1, 1}), 2);
    const Mat6 c = isotropic_elasticity(1e5, 0.3);
    for (const StrainMeasure measure : {StrainMeasure::green, StrainMeasure::corotated}) {
        for (const int order : {1, 2}) {
            Front front(tree, order, 0, 99);
            shuffle(front, random, 4);  // an odd number of batches, and a last one that is not full
            Body body(tree, front, c, measure);
            // Far from the origin and turned: differences of places must keep their digits.
            const Mat3 turn = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
            PerVertex<Vec3> x = body.plus(body.x, 1, body.random_field(random, 0.02)), v = body.random_field(random, 1);
            for (VertexId i : body.front.vertices()) x[i] = turn * x[i] + Vec3(100, -50, 20);
            const PerVertex<Vec3> expected = body.force(x);
            const double energy = body.elements.energy();
            body.elements.evaluate({.x = x, .single = true});
            EXPECT_NEAR(body.elements.energy(), energy, 2e-5 * energy);
            PerVertex<Vec3> f(tree.vertex_count(), Vec3::Zero());
            body.elements.accumulate(f);
            Vec3 sum = Vec3::Zero();
            double largest = 0;
            for (VertexId i : body.front.vertices()) {
                sum += f[i];
                largest = std::max(largest, f[i].norm());
            }
            EXPECT_LT(sum.norm(), 1e-12 * largest * static_cast<double>(body.front.vertices().size()));
            body.front.restrict_to_free(f);
            for (VertexId i : body.front.vertices()) {
                if (body.front.state(i) != VertexState::free) continue;
                EXPECT_LT((f[i] - expected[i]).norm(), 1e-5 * largest);
            }
            EXPECT_NE(body.dot(f, f), body.dot(expected, expected));  // it has been single
        }
    }
}

TEST(ElementSet, SinglePrecisionHasDampingAndEveryMatrixToo) {
    std::mt19937 random(12);
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 1);
    const PooledPerTet<Sym6> elasticity(tree.tet_count(), Sym6::from(isotropic_elasticity(1e4, 0.3)));
    const PerTet<double> density(tree.tet_count(), 1000.0), mass_damping(tree.tet_count(), 2.0), stiffness_damping(tree.tet_count(), 0.05);
    for (const StrainMeasure measure : {StrainMeasure::green, StrainMeasure::corotated}) {
        const Front front(tree, 2, 0, 99);
        ElementSet elements;
        elements.set_strain_measure(measure);
        elements.build(front, {elasticity, density, mass_damping, stiffness_damping});
        // Moderate, all at one point, inside out, flat.
        for (const Vec3& stretch : {Vec3(1.1, 0.9, 1), Vec3(0, 0, 0), Vec3(-1, 1, 1), Vec3(1, 1, 0)}) {
            PerVertex<Vec3> x = tree.rest(), v(tree.vertex_count(), Vec3::Zero());
            for (VertexId i : front.vertices()) {
                x[i] = stretch.cwiseProduct(x[i]);
                v[i] = random_vector(random);
            }
            PerVertex<Vec3> f(tree.vertex_count(), Vec3::Zero()), expected = f;
            elements.evaluate({.x = x, .velocity = &v});
            elements.accumulate(expected);
            elements.evaluate({.x = x, .velocity = &v, .single = true});
            elements.accumulate(f);
            double largest = 0, worst = 0;
            for (VertexId i : front.vertices()) {
                ASSERT_TRUE(f[i].allFinite());
                largest = std::max(largest, expected[i].norm());
                worst = std::max(worst, (f[i] - expected[i]).norm());
            }
            // Where singular values coincide at a kink of the corotated energy the rotation is anybody's choice.
            if (measure == StrainMeasure::green || stretch[0] > 1) EXPECT_LT(worst, 1e-5 * largest) << stretch.transpose();
        }
    }
}

}  // namespace
}  // namespace tetfront
