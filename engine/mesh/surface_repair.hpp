#pragma once
// Makes a triangle soup as good a surface as it can be without inventing geometry: what files hold is often not what
// their author saw on the screen.
//
//     SurfaceRepairs repairs = repair(surface);
//     std::cout << describe(repairs);

#include "engine/mesh/tet_mesh.hpp"

#include <string>

namespace tetfront {

/// What was done, and what is left as it was.
struct SurfaceRepairs {
    std::size_t parts = 0;                 // of the file that were merged
    std::size_t welded_vertices = 0;       // had the position of another one
    std::size_t unused_vertices = 0;       // belonged to no triangle
    std::size_t degenerate_triangles = 0;  // two corners at one position: dropped
    std::size_t duplicate_triangles = 0;   // dropped
    std::size_t flipped_triangles = 0;     // turned to agree with their neighbours, or outwards
    std::size_t components = 0;            // connected by edges that two triangles share
    std::size_t open_edges = 0;            // belong to one triangle: holes. Not repaired
    std::size_t nonmanifold_edges = 0;     // belong to more than two. Not repaired
};

/// Welds vertices at bitwise equal positions, drops triangles with repeated corners, duplicates and unused vertices,
/// and orients each component: neighbours agree; a closed component that no other one encloses faces outwards; one
/// inside of others keeps its orientation relative to the outermost (so that a cavity stays a cavity); an open one
/// faces outwards where it clearly encloses something. Indices must be valid.
SurfaceRepairs repair(SurfaceMesh& surface);

/// One line for each kind of repair that happened and each defect that is left; empty when there is nothing to say.
std::string describe(const SurfaceRepairs& repairs);

}  // namespace tetfront
