#include "engine/mechanics/adaptivity.hpp"

#include <gtest/gtest.h>

#include "tests/support/fronts.hpp"

namespace tetfront {
namespace {

using testing::shuffle;

class AdaptivityOfOrder : public ::testing::TestWithParam<int> {
 protected:
    const TetTree tree{box_mesh({0, 0, 0}, {2, 1, 1}, {4, 2, 2}), 3};
    const PerTet<std::uint8_t> nothing_unresolved = PerTet<std::uint8_t>(tree.tet_count(), 0);
    const PerTet<double> density = PerTet<double>(tree.tet_count(), 1000.0);

    /// A rod of two materials in series (no Poisson effect) under tension, its exact solution given: strain jumps at x = 1 by the
    /// contrast. The estimate on a random front; every tet is of one material.
    double estimate_of_exact_solution(double contrast) {
        ElasticityMatrices matrices;
        PerTet<Sym6> elasticity(tree.tet_count());
        for (TetId t : ids<TetId>(tree.tet_count())) {
            double centre = 0;
            for (VertexId v : tree.corners(t)) centre += tree.rest(v)[0] / 4;
            elasticity[t] = Sym6::from(isotropic_elasticity(centre < 1 ? 1e6 : 1e6 * contrast, 0));
        }
        matrices.elasticity = PooledPerTet<Sym6>(elasticity);
        std::mt19937 random(5);
        Front front(tree, GetParam(), 0, 99);
        shuffle(front, random, 3, 0.1, 0.05);
        EXPECT_GT(front.hanging().size(), 10U);
        ElementSet elements;
        elements.build(front, {matrices.elasticity, density});
        PerVertex<Vec3> x = tree.rest();
        for (VertexId v : front.vertices()) x[v][0] += x[v][0] < 1 ? 0.1 * x[v][0] : 0.1 + 0.1 / contrast * (x[v][0] - 1);
        elements.evaluate({.x = x});
        Adaptivity adaptivity(matrices, nothing_unresolved);
        adaptivity.measure(front, elements, x, 0, 0, {});
        return adaptivity.estimate();
    }
};
INSTANTIATE_TEST_SUITE_P(Orders, AdaptivityOfOrder, ::testing::Values(1, 2));

TEST_P(AdaptivityOfOrder, AnExactSolutionHasNoErrorAlsoWhereTheMaterialJumps) {
    EXPECT_LT(estimate_of_exact_solution(1), 1e-20);
    EXPECT_LT(estimate_of_exact_solution(10), 1e-20);
    EXPECT_LT(estimate_of_exact_solution(1000), 1e-20);
    EXPECT_GT(estimate_of_exact_solution(1.5), 1e-4) << "tets of similar stiffness are averaged: they may be a gradient";
}

}  // namespace
}  // namespace tetfront
