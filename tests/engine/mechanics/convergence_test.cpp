// How fast the displacement converges, and what order 2 reproduces exactly: on uniform fronts and on fronts of mixed levels.
#include <cmath>

#include <gtest/gtest.h>

#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/multilevel.hpp"
#include "engine/mechanics/pcg.hpp"
#include "tests/support/fronts.hpp"

namespace tetfront {
namespace {

using testing::random_vector;
using testing::shuffle;

constexpr double young = 1e5, poisson = 0.3;
constexpr double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));

bool on_boundary(const Vec3& p) { return (p.array() < 1e-9).any() || (p.array() > 1 - 1e-9).any(); }

/// A displacement of plane waves, small enough for linear elasticity, and the body force [N/m^3] that holds it.
struct Waves {
    static constexpr double amplitude = 1e-6;  // [m]
    std::vector<std::pair<Vec3, Vec3>> waves = {{{0.8, -0.5, 0.3}, {2.1, 1.2, -0.7}}, {{-0.2, 0.4, 0.9}, {-0.8, 1.9, 1.6}}};

    Vec3 displacement(const Vec3& p) const {
        Vec3 u = Vec3::Zero();
        for (const auto& [d, k] : waves) u += amplitude * std::sin(k.dot(p) + 0.4) * d;
        return u;
    }
    /// -div sigma.
    Vec3 force(const Vec3& p) const {
        Vec3 f = Vec3::Zero();
        for (const auto& [d, k] : waves)
            f += amplitude * std::sin(k.dot(p) + 0.4) * ((lambda + mu) * d.dot(k) * k + mu * k.squaredNorm() * d);
        return f;
    }
};

/// Root mean square error over all vertices of the tree, in amplitudes: those that the front does not have are interpolated, so
/// that the fields between nodes count, too.
double static_error(const TetTree& tree, const Front& front) {
    const Waves waves;
    const PooledPerTet<Sym6> elasticity(tree.tet_count(), Sym6::from(isotropic_elasticity(young, poisson)));
    const PerTet<double> density(tree.tet_count(), 1.0);
    PerVertex<std::uint8_t> pinned(tree.vertex_count(), 0);
    PerVertex<Vec3> x(tree.vertex_count(), Vec3::Zero()), minus_force = x, residual = x;
    for (VertexId v : ids<VertexId>(tree.vertex_count())) {
        const Vec3& p = tree.rest(v);
        pinned[v] = on_boundary(p);
        x[v] = p + waves.displacement(p);
        minus_force[v] = -waves.force(p);
    }
    front.prolong(x);
    ElementSet elements;
    elements.build(front, {elasticity, density});
    BlockMatrix matrix;
    matrix.build(front, elements, pinned);
    elements.evaluate({.x = tree.rest(), .tangent = true, .stiffness_scale = 1});
    matrix.fill(elements);
    Multilevel preconditioner;
    preconditioner.build(front, {elasticity, density}, pinned, matrix);
    preconditioner.update(matrix, {.stiffness_scale = 1, .mass_scale = 0, .damping_scale = 0, .x = tree.rest()});
    DofVector right(matrix.size()), update(matrix.size());
    Pcg pcg;
    for (int newton = 0; newton < 3; ++newton) {  // the matrix holds floats, the residual does not
        elements.evaluate({.x = x, .inertia = &minus_force});
        elements.accumulate(residual);
        front.restrict_to_free(residual);
        for (std::size_t i = 0; i < right.size(); ++i) right[i] = residual[matrix.vertices()[i]];
        update.assign(update.size(), Vec3::Zero());
        EXPECT_TRUE(pcg.solve(matrix, preconditioner, right, update, {1e-6, 2000}).converged);
        for (std::size_t i = 0; i < update.size(); ++i) x[matrix.vertices()[i]] += update[i];
        front.prolong(x);
    }
    double sum = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count())) {
        if (front.state(v) == VertexState::absent) x[v] = front.interpolate(x, v);
        sum += (x[v] - tree.rest(v) - waves.displacement(tree.rest(v))).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(tree.vertex_count())) / Waves::amplitude;
}

class ConvergenceOfOrder : public ::testing::TestWithParam<int> {
 protected:
    const TetTree tree{box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), 4};
    const int order = GetParam();

    /// log2 of the error's fall from one level to the next.
    double rate(int level, bool mixed) const {
        std::array<double, 2> errors{};
        for (int k = 0; k < 2; ++k) {
            Front front(tree, order, level + k, 99);
            if (mixed) {
                const std::vector<TetId> active = front.active();
                for (TetId t : active) {
                    Vec3 centre = Vec3::Zero();
                    for (VertexId v : tree.corners(t)) centre += tree.rest(v) / 4;
                    if ((centre - Vec3(0.1, 0.2, 0.3)).norm() < 0.6) front.split(t);
                }
                front.commit();
                EXPECT_GT(front.hanging().size(), 30U);
            }
            errors[static_cast<std::size_t>(k)] = static_error(tree, front);
        }
        EXPECT_LT(errors[1], 0.05);
        return std::log2(errors[0] / errors[1]);
    }
};
INSTANTIATE_TEST_SUITE_P(Orders, ConvergenceOfOrder, ::testing::Values(1, 2));

TEST_P(ConvergenceOfOrder, UniformFronts) { EXPECT_NEAR(rate(order == 1 ? 2 : 1, false), order + 1, 0.15); }
TEST_P(ConvergenceOfOrder, FrontsOfMixedLevels) { EXPECT_NEAR(rate(order == 1 ? 2 : 1, true), order + 1, 0.15); }

TEST(QuadraticPatchTest, HoldsOnRandomBalancedFronts) {
    // Any quadratic displacement, under the constant body force that belongs to it, leaves the free vertices inside without force,
    // to first order in the displacement: that part of the force is found by extrapolation of odd differences.
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {3, 3, 3}), 3);
    std::mt19937 random(11);
    for (int trial = 0; trial < 4; ++trial) {
        Front front(tree, 2, 0, 99);
        shuffle(front, random, 1, 0.5, 0);
        shuffle(front, random, 3, 0.06, 0.05);
        ASSERT_GT(front.hanging().size(), 30U);
        // u_i = p^T H_i p + (A p)_i; div sigma = (lambda + mu) grad div u + mu laplace u.
        std::array<Mat3, 3> h;
        for (Mat3& m : h) {
            m = Mat3::NullaryExpr([&] { return random_vector(random)[0]; });
            m = (m + m.transpose()).eval();
        }
        const Mat3 a = Mat3::NullaryExpr([&] { return random_vector(random)[0]; });
        Vec3 force;
        for (int i = 0; i < 3; ++i) {
            double grad_div = 0;
            for (int j = 0; j < 3; ++j) grad_div += 2 * h[static_cast<std::size_t>(j)](j, i);
            force[i] = -((lambda + mu) * grad_div + mu * 2 * h[static_cast<std::size_t>(i)].trace());
        }
        const PooledPerTet<Sym6> elasticity(tree.tet_count(), Sym6::from(isotropic_elasticity(young, poisson)));
        const PerTet<double> density(tree.tet_count(), 1.0);
        ElementSet elements;
        elements.build(front, {elasticity, density});
        PerVertex<Vec3> x = tree.rest(), sum(tree.vertex_count(), Vec3::Zero()), part = sum;
        const PerVertex<Vec3> minus_force(tree.vertex_count(), -force);
        const auto add = [&](double t, double weight) {
            for (VertexId v : front.vertices()) {
                const Vec3& p = tree.rest(v);
                x[v] = p + t * (Vec3(p.dot(h[0] * p), p.dot(h[1] * p), p.dot(h[2] * p)) + a * p);
            }
            elements.evaluate({.x = x});
            elements.accumulate(part);
            for (VertexId v : front.vertices()) sum[v] += weight * part[v];
        };
        constexpr double t = 1e-4;
        for (double sign : {1.0, -1.0}) {
            add(sign * t, -sign / (6 * t));
            add(sign * t / 2, sign * 8 / (6 * t));
        }
        elements.evaluate({.x = tree.rest(), .inertia = &minus_force});
        elements.accumulate(part);
        double largest = 0, inside = 0;
        int count = 0;
        for (VertexId v : front.vertices()) {
            largest = std::max(largest, sum[v].norm());
            sum[v] += part[v];
        }
        front.restrict_to_free(sum);
        for (VertexId v : front.vertices()) {
            if (front.state(v) != VertexState::free || on_boundary(tree.rest(v))) continue;
            inside = std::max(inside, sum[v].norm());
            ++count;
        }
        EXPECT_GT(count, 50);
        EXPECT_LT(inside, 1e-9 * largest);
    }
}

}  // namespace
}  // namespace tetfront
