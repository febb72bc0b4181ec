#include "engine/mesh/tet_mesh.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

double volume_of(const TetMesh& mesh) {
    double volume = 0;
    for (const auto& c : mesh.corners)
        volume += signed_volume(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], mesh.positions[c[3]]);
    return volume;
}

/// Message of the InputError that `validate` throws, or "".
std::string complaint(const TetMesh& mesh) {
    try {
        validate(mesh);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TetMesh two_tets() {
    TetMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    mesh.corners = {{VertexId{0}, VertexId{1}, VertexId{2}, VertexId{3}},
                    {VertexId{1}, VertexId{2}, VertexId{3}, VertexId{4}}};
    return mesh;
}

TEST(TetMesh, VolumeIsSigned) {
    const Vec3 o(0, 0, 0), x(2, 0, 0), y(0, 3, 0), z(0, 0, 4);
    EXPECT_DOUBLE_EQ(signed_volume(o, x, y, z), 4);
    EXPECT_DOUBLE_EQ(signed_volume(o, y, x, z), -4);
}

TEST(TetMesh, DihedralAnglesOfKnownTets) {
    const auto regular = dihedral_range({1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1});
    EXPECT_NEAR(regular[0], 70.528779365509308, 1e-10);
    EXPECT_NEAR(regular[1], 70.528779365509308, 1e-10);
    const auto corner = dihedral_range({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    EXPECT_NEAR(corner[0], 54.735610317245346, 1e-10);
    EXPECT_NEAR(corner[1], 90, 1e-10);
    EXPECT_EQ(dihedral_range({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}), (std::array<double, 2>{0, 180}));
    const auto flat = dihedral_range({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    EXPECT_NEAR(flat[0], 0, 1e-6);
    EXPECT_NEAR(flat[1], 180, 1e-6);
}

TEST(TetMesh, BoxFillsItsVolumeWithKuhnTets) {
    const TetMesh mesh = box_mesh({-1, 0, 2}, {3, 1, 3}, {8, 2, 2});
    EXPECT_NO_THROW(validate(mesh));
    EXPECT_EQ(mesh.corners.size(), 6u * 8 * 2 * 2);
    EXPECT_EQ(mesh.positions.size(), 9u * 3 * 3);
    EXPECT_NEAR(volume_of(mesh), 4, 1e-12);
    for (const auto& c : mesh.corners) {
        const auto angles =
            dihedral_range(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], mesh.positions[c[3]]);
        EXPECT_NEAR(angles[0], 45, 1e-9);
        EXPECT_NEAR(angles[1], 90, 1e-9);
        // The refinement's diagonal joins the midpoints of corners 0-2 and 1-3: the shortest of the three.
        const auto diagonal = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
            return (mesh.positions[c[i]] + mesh.positions[c[j]] - mesh.positions[c[k]] - mesh.positions[c[l]]).norm();
        };
        EXPECT_LE(diagonal(0, 2, 1, 3), diagonal(0, 1, 2, 3) + 1e-12);
        EXPECT_LE(diagonal(0, 2, 1, 3), diagonal(0, 3, 1, 2) + 1e-12);
    }
}

TEST(TetMesh, BoxRefusesEmptySizes) {
    EXPECT_THROW(box_mesh({0, 0, 0}, {1, 0, 1}, {1, 1, 1}), InputError);
    EXPECT_THROW(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 0, 1}), InputError);
    EXPECT_THROW(box_mesh({0, 0, 0}, {1, 1, std::numeric_limits<double>::quiet_NaN()}, {1, 1, 1}), InputError);
    EXPECT_THROW(box_mesh({0, 0, 0}, {1, 1, 1}, {100000, 100000, 100000}), InputError);
}

TEST(TetMesh, BoundaryIsClosedAndPointsOutwards) {
    const TetMesh mesh = box_mesh({0, 0, 0}, {2, 1, 1}, {4, 2, 3});
    const SurfaceMesh skin = boundary_surface(mesh);
    EXPECT_EQ(skin.triangles.size(), 2u * 2 * (4 * 2 + 2 * 3 + 3 * 4));
    EXPECT_EQ(skin.positions.size(), skin.triangles.size() / 2 + 2);  // Euler: V - E + F = 2, E = 3F/2
    std::map<std::pair<int, int>, int> directed;
    double volume = 0;
    for (const auto& t : skin.triangles) {
        for (std::size_t i = 0; i < 3; ++i) ++directed[{t[i], t[(i + 1) % 3]}];
        const auto& x = skin.positions;
        volume += x[static_cast<std::size_t>(t[0])]
                      .cross(x[static_cast<std::size_t>(t[1])])
                      .dot(x[static_cast<std::size_t>(t[2])]) /
                  6;
    }
    EXPECT_NEAR(volume, 2, 1e-12);
    for (const auto& [edge, count] : directed) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(directed.count({edge.second, edge.first}), 1u);
    }
}

TEST(TetMesh, ValidateAcceptsGoodMeshes) { EXPECT_EQ(complaint(two_tets()), ""); }

TEST(TetMesh, ValidateNamesTheCulprit) {
    TetMesh mesh = two_tets();
    mesh.corners[TetId{1}][2] = VertexId{9};
    EXPECT_NE(complaint(mesh).find("tet 1: refers to vertex 9"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.corners[TetId{1}][2] = VertexId{};
    EXPECT_NE(complaint(mesh).find("tet 1"), std::string::npos);

    mesh = two_tets();
    mesh.corners[TetId{1}][2] = VertexId{1};
    EXPECT_NE(complaint(mesh).find("tet 1: has vertex 1 at two corners"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    std::swap(mesh.corners[TetId{0}][0], mesh.corners[TetId{0}][1]);
    EXPECT_NE(complaint(mesh).find("tet 0: has the volume"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.positions[VertexId{4}] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    mesh.positions[VertexId{4}][0] = std::numeric_limits<double>::infinity();
    EXPECT_NE(complaint(mesh).find("vertex 4"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.positions.emplace_back(7, 7, 7);
    EXPECT_NE(complaint(mesh).find("vertex 5: belongs to no tet"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.positions.emplace_back(2, 2, 3);
    mesh.corners.push_back({VertexId{1}, VertexId{2}, VertexId{3}, VertexId{5}});
    EXPECT_NE(complaint(mesh).find("3 tets share"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.corners.push_back(mesh.corners[TetId{0}]);
    EXPECT_NE(complaint(mesh).find("tet 2"), std::string::npos) << complaint(mesh);

    mesh = two_tets();  // a second tet on the same side of the common face
    mesh.positions[VertexId{4}] = {-1, -1, -1};
    std::swap(mesh.corners[TetId{1}][0], mesh.corners[TetId{1}][1]);
    EXPECT_NE(complaint(mesh).find("same side"), std::string::npos) << complaint(mesh);

    mesh = two_tets();
    mesh.region = {0};
    EXPECT_NE(complaint(mesh).find("1 regions for 2 tets"), std::string::npos) << complaint(mesh);

    EXPECT_NE(complaint(TetMesh{}), "");
}

}  // namespace
}  // namespace tetfront
