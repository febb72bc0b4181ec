#include "engine/tree/front.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/fronts.hpp"

namespace tetfront {
namespace {

using testing::random_vector;
using testing::shuffle;

class FrontOfOrder : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, FrontOfOrder, ::testing::Values(1, 2));

TEST_P(FrontOfOrder, InvariantsHoldWhileSplittingAndMergingAtRandom) {
    const TetTree tree(box_mesh({0, 0, 0}, {2, 1, 1}, {4, 2, 2}), GetParam() == 1 ? 3 : 4);
    std::mt19937 random(7);
    Front front(tree, GetParam(), 0, 99);
    front.validate();
    bool jump_of_two = false;
    for (int round = 0; round < 25; ++round) {
        shuffle(front, random, 1, round < 12 ? 0.06 : 0.01, round < 12 ? 0.05 : 0.5);
        front.validate();
        for (VertexId v : front.hanging()) {
            for (VertexId u : tree.row(GetParam(), v).vertices) jump_of_two = jump_of_two || front.state(u) == VertexState::hanging;
        }
    }
    // (The balance of order 2 leaves chains to rare corners.)
    if (GetParam() == 1) EXPECT_TRUE(jump_of_two) << "the random fronts do not exercise chains of hanging vertices";
}

TEST_P(FrontOfOrder, LocalSplitsGoDeepAndBack) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), 4);
    Front front(tree, GetParam(), 0, 99);
    const std::size_t coarse = front.active().size();
    for (int level = 0; level < front.max_level(); ++level) {
        TetId deepest = front.active().back();
        ASSERT_TRUE(front.split(deepest));
        front.commit();
        front.validate();
    }
    EXPECT_EQ(tree.level_of(front.active().back()), front.max_level());
    EXPECT_LT(front.active().size(), tree.tet_count(tree.depth()) / 8) << "refinement stays local";
    for (int pass = 0; pass < 8; ++pass) {
        const std::vector<TetId> active = front.active();
        for (TetId t : active)
            if (!tree.is_root(t) && front.can_merge(tree.parent(t))) front.merge(tree.parent(t));
        front.commit();
        front.validate();
    }
    EXPECT_EQ(front.active().size(), coarse) << "everything merges again";
}

TEST_P(FrontOfOrder, ProlongAndRestrictAreTransposes) {
    const TetTree tree(box_mesh({0, 0, 0}, {2, 1, 1}, {4, 2, 2}), 3);
    std::mt19937 random(3);
    Front front(tree, GetParam(), 0, 99);
    shuffle(front, random, 4, 0.08, 0.05);
    ASSERT_GT(front.hanging().size(), 20U);
    PerVertex<Vec3> x(tree.vertex_count()), f(tree.vertex_count());
    for (VertexId v : front.vertices()) {
        x[v] = random_vector(random);
        f[v] = random_vector(random);
    }
    const PerVertex<Vec3> force = f;
    const PerVertex<Vec3> free = x;
    front.prolong(x);
    front.restrict_to_free(f);
    double forward = 0, backward = 0;
    for (VertexId v : front.vertices()) {
        forward += x[v].dot(force[v]);
        if (front.state(v) == VertexState::free) backward += free[v].dot(f[v]);
    }
    EXPECT_NEAR(forward, backward, 1e-12 * std::abs(forward) + 1e-12);
}

TEST_P(FrontOfOrder, HangingAndAbsentVerticesReproduceTheElementField) {
    // Any field of the element space, evaluated by rows at every younger vertex, is the shape functions' value there.
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    std::mt19937 random(5);
    Front front(tree, GetParam(), 0, 99);
    shuffle(front, random, 4, 0.1, 0.1);
    PerVertex<double> u(tree.vertex_count(), 0);
    for (VertexId v : front.vertices()) u[v] = random_vector(random)[0];
    front.prolong(u);
    for (VertexId v : ids<VertexId>(tree.vertex_count()))
        if (front.state(v) == VertexState::absent) u[v] = front.interpolate(u, v);
    for (TetId leaf : tree.level(tree.depth())) {
        for (int k = 0; k < 4; ++k) {
            const Front::Point p = front.locate(leaf, Vec4::Unit(k));
            double sum = 0;
            for (std::size_t i = 0; i < static_cast<std::size_t>(front.nodes_per_tet()); ++i) sum += p.weights[i] * u[p.nodes[i]];
            EXPECT_NEAR(sum, u[tree.corners(leaf)[static_cast<std::size_t>(k)]], 1e-12);
        }
    }
}

TEST_P(FrontOfOrder, CommitReportsExactlyWhatChanged) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    std::mt19937 random(11);
    Front front(tree, GetParam(), 0, 99);
    for (int round = 0; round < 10; ++round) {
        PerVertex<VertexState> before(tree.vertex_count());
        for (VertexId v : ids<VertexId>(tree.vertex_count())) before[v] = front.state(v);
        const std::uint32_t epoch = front.epoch();
        const std::vector<TetId> active = front.active();
        for (TetId t : active)
            if (random() % 8 == 0) front.split(t);
        const Front::Change change = front.commit();
        std::vector<VertexId> appeared, tied;
        for (VertexId v : ids<VertexId>(tree.vertex_count())) {
            if (before[v] == VertexState::absent && front.state(v) != VertexState::absent) appeared.push_back(v);
            if (before[v] == VertexState::free && front.state(v) == VertexState::hanging) tied.push_back(v);
        }
        EXPECT_EQ(change.appeared, appeared);
        EXPECT_EQ(change.tied, tied);
        EXPECT_EQ(front.epoch() != epoch, front.active() != active);
    }
}

TEST(Front, LimitsOfLevels) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 2);
    Front linear(tree, 1, 1, 1);
    EXPECT_EQ(linear.active().size(), 48U);
    EXPECT_FALSE(linear.split(linear.active().front()));
    EXPECT_FALSE(linear.can_merge(tree.parent(linear.active().front())));
    Front quadratic(tree, 2, 0, 99);
    EXPECT_EQ(quadratic.max_level(), 1) << "a quadratic tet needs its children's vertices";
}

}  // namespace
}  // namespace tetfront
