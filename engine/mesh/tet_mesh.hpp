#pragma once
// The two plain meshes that everything starts from: a tetrahedral rest mesh and a triangle surface.
//
//     TetMesh box = box_mesh({0, 0, 0}, {4, 1, 1}, {8, 2, 2});
//     validate(box);                                   // throws InputError that names the first bad tet
//     SurfaceMesh skin = boundary_surface(box);

#include "engine/base/types.hpp"

#include <array>
#include <vector>

namespace tetfront {

/// Triangles, counter-clockwise seen from outside.
struct SurfaceMesh {
    std::vector<Vec3> positions;                         // [S] metres
    std::vector<std::array<std::int32_t, 3>> triangles;  // [F] indices into positions
};

/// Tetrahedra that meet face to face.
struct TetMesh {
    PerVertex<Vec3> positions;                // [V] metres
    PerTet<std::array<VertexId, 4>> corners;  // [T] positive volume: det(x1-x0, x2-x0, x3-x0) > 0
    PerTet<std::int32_t> region;              // [T] material region, 0 where nothing is said; empty: all 0
};

/// Signed volume of a tet [m^3].
double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Smallest and largest of the six dihedral angles [degrees]; 0 and 180 for a flat tet.
std::array<double, 2> dihedral_range(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Throws InputError naming the first tet (or vertex) that breaks an invariant: no tets, index range, repeated corner,
/// volume not positive, non-finite position, a vertex that no tet uses, a face shared by more than two tets or by two
/// that lie on the same side of it.
void validate(const TetMesh& mesh);

/// Axis-aligned box from `low` to `high`, cells[i] >= 1 cubes along axis i, each cut in six tets (Kuhn). Conforming.
/// Corners are ordered so that all descendants in a TetTree have the shape of their root. Throws InputError.
TetMesh box_mesh(const Vec3& low, const Vec3& high, const std::array<int, 3>& cells);

/// Triangles of tets' faces that belong to one tet only, oriented outwards; vertices compacted.
SurfaceMesh boundary_surface(const TetMesh& mesh);

}  // namespace tetfront
