#include "engine/mesh/tet_repair.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::array<VertexId, 4> tet(int a, int b, int c, int d) { return {VertexId{a}, VertexId{b}, VertexId{c}, VertexId{d}}; }

double volume(const TetMesh& mesh, TetId t) {
    const auto& c = mesh.corners[t];
    return signed_volume(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], mesh.positions[c[3]]);
}

/// Two tets that have only vertex 0 in common.
TetMesh touching_in_a_vertex() {
    TetMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    mesh.corners = {tet(0, 1, 2, 3), tet(0, 5, 4, 6)};
    return mesh;
}
/// Two tets that have only the edge 0-1 in common.
TetMesh touching_in_an_edge() {
    TetMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
    mesh.corners = {tet(0, 2, 3, 1), tet(0, 4, 5, 1)};
    return mesh;
}

TEST(TetRepair, PinchedVertexComesApart) {
    TetMesh mesh = touching_in_a_vertex();
    ASSERT_NO_THROW(validate(mesh));
    EXPECT_EQ(separate_pinches(mesh), 1u);
    EXPECT_EQ(mesh.positions.size(), 8u);
    EXPECT_EQ(mesh.positions[VertexId{7}], Vec3(0, 0, 0));
    EXPECT_EQ(mesh.corners[TetId{0}], tet(0, 1, 2, 3));
    EXPECT_EQ(mesh.corners[TetId{1}], tet(7, 5, 4, 6));
    EXPECT_EQ(separate_pinches(mesh), 0u);
}

TEST(TetRepair, PinchedEdgeComesApart) {
    TetMesh mesh = touching_in_an_edge();
    ASSERT_NO_THROW(validate(mesh));
    EXPECT_EQ(count_pinched_edges(mesh), 1u);
    EXPECT_EQ(separate_pinches(mesh), 2u);
    EXPECT_EQ(count_pinched_edges(mesh), 0u);
    EXPECT_EQ(std::ranges::max(connected_pieces(mesh)), 1);
    EXPECT_NO_THROW(validate(mesh));
}

TEST(TetRepair, SoundMeshesStay) {
    TetMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}, {2, 2, 2});
    const TetMesh before = mesh;
    EXPECT_EQ(separate_pinches(mesh), 0u);
    EXPECT_EQ(count_pinched_edges(mesh), 0u);
    EXPECT_EQ(mesh.corners, before.corners);
    EXPECT_EQ(std::ranges::max(connected_pieces(mesh)), 0);
}

TEST(TetRepair, KeepCompactsVerticesAndRegions) {
    TetMesh mesh = touching_in_a_vertex();
    mesh.region = {3, 4};
    const auto piece = connected_pieces(mesh);
    EXPECT_EQ(piece, (PerTet<std::int32_t>{0, 1}));
    const TetMesh second = keep_tets(mesh, [&](TetId t) { return piece[t] == 1; });
    EXPECT_NO_THROW(validate(second));
    EXPECT_EQ(second.positions.size(), 4u);
    EXPECT_EQ(second.region, (PerTet<std::int32_t>{4}));
    EXPECT_DOUBLE_EQ(volume(second, TetId{0}), volume(mesh, TetId{1}));
}

/// Smallest dihedral angle of the four inner children for the diagonal between the midpoints of 0-2 and 1-3.
double inner_angle(const TetMesh& mesh, const std::array<VertexId, 4>& c) {
    const auto m = [&](std::size_t i, std::size_t j) -> Vec3 { return mesh.positions[c[i]] + mesh.positions[c[j]]; };
    double worst = 180;
    const std::array<Vec3, 4> ring = {m(0, 1), m(1, 2), m(2, 3), m(3, 0)};
    for (std::size_t i = 0; i < 4; ++i) {
        const auto [low, high] = dihedral_range(m(0, 2), m(1, 3), ring[i], ring[(i + 1) % 4]);
        worst = std::min({worst, low, 180 - high});
    }
    return worst;
}

TEST(TetRepair, OrderGivesTheBestDescendants) {
    // Every order of the corners of a tet whose three diagonals differ.
    const std::array<Vec3, 4> corners = {Vec3(0, 0, 0), Vec3(3, 0.2, 0), Vec3(0.4, 1, 0), Vec3(1, 0.3, 0.9)};
    std::array<int, 4> order = {0, 1, 2, 3};
    double best = 0, worst = 180;
    do {
        TetMesh mesh;
        for (int i : order) mesh.positions.push_back(corners[static_cast<std::size_t>(i)]);
        mesh.corners = {tet(0, 1, 2, 3)};
        const double before = volume(mesh, TetId{0});
        worst = std::min(worst, inner_angle(mesh, mesh.corners[TetId{0}]));
        order_for_refinement(mesh);
        EXPECT_DOUBLE_EQ(volume(mesh, TetId{0}), before);
        const double angle = inner_angle(mesh, mesh.corners[TetId{0}]);
        if (best > 0) {
            EXPECT_NEAR(angle, best, 1e-6);
        }
        best = angle;
    } while (std::next_permutation(order.begin(), order.end()));
    EXPECT_GT(best, worst + 1) << "the order does not matter for this tet";
}

}  // namespace
}  // namespace tetfront
