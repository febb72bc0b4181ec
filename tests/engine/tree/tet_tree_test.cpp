#include "engine/tree/tet_tree.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

namespace tetfront {
namespace {

TetMesh irregular_tet() {
    TetMesh mesh;
    mesh.positions = {{0, 0, 0}, {1.3, 0.1, 0.2}, {0.2, 0.9, -0.1}, {0.1, 0.3, 1.1}};
    mesh.corners = {{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}};
    return mesh;
}

TEST(TetTree, InvariantsHold) {
    TetTree(box_mesh({0, 0, 0}, {4, 1, 1}, {4, 1, 1}), 3).validate();
    TetTree(irregular_tet(), 4).validate();
    TetTree(irregular_tet(), 0).validate();
}

TEST(TetTree, CountsFollowTheSubdivision) {
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {8, 2, 2}), 3);
    EXPECT_EQ(tree.tet_count(0), 192U);
    EXPECT_EQ(tree.tet_count(3), 98304U);
    // Vertices of a Kuhn box refined k times: the grid points of the refined box.
    for (int level = 0; level <= 3; ++level) {
        const std::size_t n = std::size_t{1} << level;
        EXPECT_EQ(tree.vertex_count(level), (8 * n + 1) * (2 * n + 1) * (2 * n + 1)) << level;
    }
}

/// Shape up to similarity: sorted edge lengths over the longest. Equal for congruent tets scaled.
std::array<long, 6> shape(const TetTree& tree, TetId t) {
    std::array<double, 6> length{};
    const auto& c = tree.corners(t);
    for (std::size_t e = 0; e < 6; ++e)
        length[e] = (tree.rest(c[static_cast<std::size_t>(tet_edges[e][0])]) - tree.rest(c[static_cast<std::size_t>(tet_edges[e][1])])).norm();
    std::sort(length.begin(), length.end());
    std::array<long, 6> s{};
    for (std::size_t e = 0; e < 6; ++e) s[e] = std::lround(length[e] / length[5] * 1e7);
    return s;
}

TEST(TetTree, AtMostThreeCongruenceClassesPerRoot) {
    const TetTree tree(irregular_tet(), 5);
    std::set<std::array<long, 6>> shapes;
    for (TetId t : ids<TetId>(tree.tet_count())) shapes.insert(shape(tree, t));
    EXPECT_LE(shapes.size(), 3U);
    EXPECT_GT(shapes.size(), 1U);
}

TEST(TetTree, WorstQualityDoesNotFallWithDepth) {
    const TetTree tree(irregular_tet(), 4);
    std::array<double, 5> worst;
    worst.fill(180);
    for (TetId t : ids<TetId>(tree.tet_count())) {
        const auto& c = tree.corners(t);
        double& w = worst[static_cast<std::size_t>(tree.level_of(t))];
        w = std::min(w, dihedral_range(tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3]))[0]);
    }
    for (std::size_t level = 2; level <= 4; ++level) EXPECT_NEAR(worst[level], worst[1], 1e-6);
}

TEST(TetTree, EveryLevelIsConforming) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    for (int level = 0; level <= 3; ++level) {
        TetMesh mesh;
        mesh.positions = tree.rest();
        for (TetId t : tree.level(level)) mesh.corners.push_back(tree.corners(t));
        std::map<std::array<VertexId, 3>, int> faces;
        double area = 0;
        for (const auto& c : mesh.corners) {
            for (std::size_t skip = 0; skip < 4; ++skip) {
                std::array<VertexId, 3> face{};
                std::size_t n = 0;
                for (std::size_t k = 0; k < 4; ++k)
                    if (k != skip) face[n++] = c[k];
                std::sort(face.begin(), face.end());
                ++faces[face];
            }
        }
        for (const auto& [face, count] : faces) {
            ASSERT_LE(count, 2);
            if (count == 1)
                area += 0.5 * (tree.rest(face[1]) - tree.rest(face[0])).cross(tree.rest(face[2]) - tree.rest(face[0])).norm();
        }
        EXPECT_NEAR(area, 6, 1e-9) << "the boundary of level " << level << " is the cube's: no crack inside";
    }
}

TEST(TetTree, BarycentricInParentAgreesWithPositions) {
    const TetTree tree(irregular_tet(), 2);
    const Vec4 b(0.1, 0.2, 0.3, 0.4);
    const auto at = [&](TetId t, const Vec4& w) {
        Vec3 p = Vec3::Zero();
        for (int i = 0; i < 4; ++i) p += w[i] * tree.rest(tree.corners(t)[static_cast<std::size_t>(i)]);
        return p;
    };
    for (TetId t : tree.level(2)) {
        const Vec4 in_parent = barycentric_in_parent(tree.child_number(t), b);
        EXPECT_LT((at(t, b) - at(tree.parent(t), in_parent)).norm(), 1e-14);
    }
}

TEST(TetTree, QuadraticRowsReproduceQuadraticFields) {
    const TetTree tree(irregular_tet(), 4);
    const auto field = [](const Vec3& p) { return 1 + 2 * p[0] - p[1] + p[0] * p[0] - 3 * p[1] * p[2] + p[2] * p[2]; };
    int rows = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count())) {
        const auto row = tree.row(2, v);
        if (row.vertices.empty()) continue;
        ++rows;
        double sum = 0;
        for (std::size_t k = 0; k < row.vertices.size(); ++k) sum += row.weights[k] * field(tree.rest(row.vertices[k]));
        EXPECT_NEAR(sum, field(tree.rest(v)), 1e-13);
    }
    EXPECT_EQ(rows, static_cast<int>(tree.vertex_count() - tree.vertex_count(1)));
}

TEST(TetTree, RefusesTreesThatDoNotFit) {
    EXPECT_THROW(TetTree(box_mesh({0, 0, 0}, {1, 1, 1}, {20, 20, 20}), 8), InputError);
}

}  // namespace
}  // namespace tetfront
