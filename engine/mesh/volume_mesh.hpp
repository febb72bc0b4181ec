#pragma once
// Coarse, well-shaped tets for any triangle surface, also one with holes, overlaps or flipped parts: the roots of a
// TetTree, in which the surface itself is embedded later.
//
//     VolumeMesh coarse = mesh_volume(surface, {.target_tets = 1000});
//     TetTree tree(coarse.mesh, 2);
//     std::cout << describe(coarse.report);
//
// What is filled is where the winding number exceeds 1/2, and what is nearer to the surface than a margin: the flat
// faces of coarse tets cut corners, and the margin makes up for it. Thin parts (ears, fingers, sheets) that the tets
// still miss are thickened, in a few rounds, until tets cover them.

#include "engine/mesh/tet_mesh.hpp"
#include "engine/mesh/volume_report.hpp"

namespace tetfront {

struct VolumeMeshOptions {
    int target_tets = 1000;  // 10..1000000; the result has this many within 10 % where the shape allows it
    /// Outward offset as a part of the lattice's cell, 0..0.5. 0 follows the surface, vertices on convex parts of which
    /// then lie outside of the tets.
    double margin = 0.1;
    bool thicken = true;  // cover thin parts; otherwise parts thinner than a cell are lost
};

struct VolumeMesh {
    TetMesh mesh;  // passes validate(); ordered for refinement
    VolumeMeshReport report;
};

/// Throws InputError for options out of range, a surface without triangles or extent, and one whose inside no lattice
/// of the wanted size finds. Deterministic.
VolumeMesh mesh_volume(const SurfaceMesh& surface, const VolumeMeshOptions& options = {});

}  // namespace tetfront
