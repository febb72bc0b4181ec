#include "engine/mechanics/rigid_parts.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/mechanics/multilevel.hpp"
#include "engine/mechanics/pcg.hpp"
#include "tests/support/scenes.hpp"

namespace tetfront {
namespace {

/// Linear root tets of a beam along x.
struct Beam {
    Beam(const std::array<int, 3>& cells, bool clamped)
        : tree(box_mesh({0, 0, 0}, {1.0 * cells[0], 1.0 * cells[1], 1.0 * cells[2]}, cells), 0),
          front(tree, 1, 0, 0),
          elasticity(tree.tet_count(), Sym6::from(isotropic_elasticity(1e5, 0.3))),
          density(tree.tet_count(), 1000),
          pinned(tree.vertex_count(), 0) {
        for (VertexId v : ids<VertexId>(pinned.size())) pinned[v] = clamped && tree.rest(v)[0] < 1e-9;
        elements.build(front, materials());
        matrix.build(front, elements, pinned);
    }
    [[nodiscard]] TetMaterials materials() const { return {elasticity, density}; }
    /// M u of the consistent mass, and no force.
    [[nodiscard]] PerVertex<Vec3> mass_times(const PerVertex<Vec3>& u) {
        PerVertex<Vec3> minus(u.size()), product(u.size());
        elements.evaluate({.x = tree.rest(), .inertia = &u});
        elements.accumulate(minus);
        for (VertexId v : ids<VertexId>(u.size())) product[v] = -minus[v];
        return product;
    }

    TetTree tree;
    Front front;
    PooledPerTet<Sym6> elasticity;
    PerTet<double> density;
    PerVertex<std::uint8_t> pinned;
    ElementSet elements;
    BlockMatrix matrix;
};

constexpr double h = 1.0 / 60;

TEST(RigidParts, CarryMotionsOfTheWholeExactly) {
    Beam beam({16, 3, 2}, false);
    RigidParts parts;
    parts.build(beam.tree, beam.materials(), beam.pinned);
    ASSERT_FALSE(parts.empty());
    for (const double angle : {0.0, 1.0, 3.0}) {
        const Mat3 turn = Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()).toRotationMatrix();
        PerVertex<Vec3> x, u;
        for (const Vec3& rest : beam.tree.rest()) {
            x.push_back(turn * rest + Vec3(5, 6, 7));
            u.push_back(turn * (Vec3(1, -2, 0.5) + Vec3(0.3, 0.1, -0.2).cross(rest)));
        }
        parts.update(h * h, 1, h, x);
        const PerVertex<Vec3> product = beam.mass_times(u);  // K u is zero
        DofVector z(u.size());
        parts.apply(DofVector(product.begin(), product.end()), z);
        for (VertexId v : ids<VertexId>(u.size())) EXPECT_NEAR((z[v.index()] - u[v]).norm(), 0, 2e-3) << angle;
    }
}

TEST(RigidParts, AreSymmetricPositiveAndLeavePinnedVerticesAlone) {
    Beam beam({16, 3, 2}, true);
    RigidParts parts;
    parts.build(beam.tree, beam.materials(), beam.pinned);
    parts.update(h * h, 1, h, beam.tree.rest());
    const std::size_t n = beam.tree.vertex_count(0);
    const auto wave = [&](double phase) {
        DofVector r(n);
        for (std::size_t i = 0; i < n; ++i) r[i] = Vec3(std::sin(phase * static_cast<double>(i)), std::cos(2 * phase * static_cast<double>(i)), phase);
        return r;
    };
    const auto product = [&](const DofVector& a, const DofVector& b) {
        DofVector z(n);
        parts.apply(b, z);
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) sum += a[i].dot(z[i]);
        return sum;
    };
    const DofVector a = wave(0.3), b = wave(0.7);
    EXPECT_NEAR(product(a, b) / product(b, a), 1, 1e-4);
    EXPECT_GT(product(a, a), 0);
    DofVector z(n);
    parts.apply(a, z);
    for (VertexId v : ids<VertexId>(n)) EXPECT_EQ(beam.pinned[v] != 0, z[v.index()].isZero(0));
}

TEST(RigidParts, AreMadeAnewWhenPinsChange) {
    Beam beam({16, 3, 2}, true);
    RigidParts parts;
    parts.build(beam.tree, beam.materials(), beam.pinned);
    std::fill(beam.pinned.begin(), beam.pinned.end(), std::uint8_t{0});
    parts.build(beam.tree, beam.materials(), beam.pinned);
    parts.update(h * h, 1, h, beam.tree.rest());
    DofVector r(beam.tree.vertex_count(0), Vec3(1, 1, 1)), z(r.size());
    parts.apply(r, z);
    for (const Vec3& u : z) EXPECT_FALSE(u.isZero(0));
}

TEST(RigidParts, FewRootsHaveNone) {
    Beam beam({2, 1, 1}, true);
    RigidParts parts;
    parts.build(beam.tree, beam.materials(), beam.pinned);
    EXPECT_TRUE(parts.empty());
}

/// Iterations for a long first step of a beam's fall, which carries a force from its far end to where it is clamped.
int iterations(int cells, bool with_parts) {
    constexpr double step = 10;
    Beam beam({cells, 2, 2}, true);
    const PerVertex<Vec3> fall(beam.tree.vertex_count(), Vec3(0, 0, 9.81 * step));
    beam.elements.evaluate({.x = beam.tree.rest(), .inertia = &fall, .tangent = true, .stiffness_scale = step * step, .mass_scale = 1});
    beam.matrix.fill(beam.elements);
    PerVertex<Vec3> nodal(beam.tree.vertex_count(), Vec3::Zero());
    beam.elements.accumulate(nodal);
    DofVector right(beam.matrix.size()), x(beam.matrix.size(), Vec3::Zero());
    for (std::size_t i = 0; i < right.size(); ++i) right[i] = nodal[beam.matrix.vertices()[i]];
    Multilevel multilevel;
    multilevel.build(beam.front, beam.materials(), beam.pinned, beam.matrix);
    multilevel.update(beam.matrix, {.stiffness_scale = step * step, .mass_scale = 1, .damping_scale = 0, .x = beam.tree.rest(), .contacts = !with_parts});
    const PcgResult result = Pcg().solve(beam.matrix, multilevel, right, x, {1e-6, 5000});
    EXPECT_TRUE(result.converged);
    return result.iterations;
}

TEST(RigidParts, IterationsHardlyGrowWithTheLengthOfABeam) {
    const int shorter = iterations(20, true), longer = iterations(80, true), without = iterations(80, false);
    EXPECT_LT(longer, 2 * shorter);
    EXPECT_LT(longer, 0.25 * without);
}

}  // namespace
}  // namespace tetfront
