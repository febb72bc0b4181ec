#pragma once
// Connected parts of a surface: which triangles make one solid.
//
//     SurfaceParts parts = surface_parts(surface);
//     parts.of_triangle[t] < parts.count

#include "engine/mesh/tet_mesh.hpp"

#include <cstdint>
#include <vector>

namespace tetfront {

struct SurfaceParts {
    std::vector<std::int32_t> of_triangle;  // [F] number of its part, in the order of their first triangles
    std::size_t count = 0;
};

/// Parts hang together by edges of exactly two triangles: two solids that share a vertex or an edge stay two.
SurfaceParts surface_parts(const SurfaceMesh& surface);

}  // namespace tetfront
