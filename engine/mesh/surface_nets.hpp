#pragma once
// A closed triangle surface around where a field exceeds one half: surface nets (Gibson 1998).
//
// The field is sampled on a lattice. A cube whose corners disagree gets one vertex, the mean of the points where its
// edges cross one half; four cubes around a crossed edge make two triangles. Fairer than marching cubes at the same
// resolution, with the same number of vertices as cubes that the surface passes through.
//
//     SurfaceMesh ball = surface_nets({-1, -1, -1}, {1, 1, 1}, 0.1, [](const Vec3& p) { return 1.5 - 2 * p.norm(); });

#include "engine/mesh/tet_mesh.hpp"

#include <functional>

namespace tetfront {

/// [low, high]: a box that holds what is wanted; the field counts as 0 outside of it. cell: edge of the lattice's cubes
/// [m]. `field` is called from several threads; the result does not depend on their number. Empty when no sample
/// exceeds one half. Throws InputError when the box holds more than 2^27 samples.
SurfaceMesh surface_nets(const Vec3& low, const Vec3& high, double cell, const std::function<double(const Vec3&)>& field);

}  // namespace tetfront
