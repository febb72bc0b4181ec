#pragma once
// What reading a tet mesh gives: the mesh, and what had to be mended in it. See tet_file.hpp.

#include "engine/mesh/tet_mesh.hpp"

namespace tetfront {

struct TetRepairs {
    std::size_t inverted_tets = 0;      // turned around
    std::size_t straightened_tets = 0;  // quadratic, taken by their corners
    std::size_t ignored_cells = 0;      // points, lines, faces
    std::size_t unused_vertices = 0;    // belonged to no tet: dropped
    std::size_t welded_vertices = 0;    // at one position in several pieces of a .vtu file
};

struct ImportedTets {
    TetMesh mesh;  // passes validate(); ordered for refinement
    TetRepairs repairs;
};

}  // namespace tetfront
