#pragma once
// Fills the inside of any shape with well-shaped tets: isosurface stuffing (Labelle & Shewchuk 2007).
//
// A body-centred cubic lattice of tets covers the box. Where an edge of the lattice crosses the boundary, a cut point
// is found; a lattice vertex that lies too close to one is moved onto it ("warped"); what remains of each lattice tet
// is one of a handful of stencils. Whatever the shape, all dihedral angles lie between 10.7 and 164.8 degrees.
//
//     TetMesh ball = stuff_isosurface({-1, -1, -1}, {1, 1, 1}, 0.25, [](const Vec3& p) { return p.norm() < 1; });

#include "engine/mesh/tet_mesh.hpp"

#include <functional>

namespace tetfront {

/// The bounds that [Labelle & Shewchuk] prove for every shape [degrees].
inline constexpr double stuffing_min_dihedral = 10.7, stuffing_max_dihedral = 164.8;

/// Tets that approximate {inside} to second order in `cell`, the edge of the lattice's cubes [m]; about 12 of them a
/// cube. Details smaller than a cell may be lost. [low, high]: a box that holds the shape. `inside` is called from
/// several threads; the result does not depend on their number. Empty when no lattice point is inside. The mesh may
/// touch itself in a vertex or an edge, see tet_repair.hpp. Throws InputError when the box holds more than
/// 2^26 cells.
TetMesh stuff_isosurface(const Vec3& low, const Vec3& high, double cell,
                         const std::function<bool(const Vec3&)>& inside);

}  // namespace tetfront
