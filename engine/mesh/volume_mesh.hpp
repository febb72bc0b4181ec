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

#include <string>

namespace tetfront {

struct VolumeMeshOptions {
    int target_tets = 1000;  // 10..1000000; the result has this many within 10 % where the shape allows it
    /// Outward offset as a part of the lattice's cell, 0..0.5. 0 follows the surface, vertices on convex parts of which
    /// then lie outside of the tets.
    double margin = 0.1;
    bool thicken = true;  // cover thin parts; otherwise parts thinner than a cell are lost
};

struct VolumeMeshReport {
    std::size_t tets = 0, vertices = 0;
    double cell = 0;                     // [m] edge of the lattice's cubes
    double margin = 0;                   // [m] outward offset
    std::array<double, 2> dihedral{};    // [degrees] smallest and largest of all tets
    double surface_volume = 0;           // [m^3] enclosed by the surface; for an open one closed towards its middle
    double mesh_volume = 0;              // [m^3]
    double covered_volume = 0;           // part of the surface's inside that is in tets, 0..1, sampled
    std::size_t outside_count = 0;       // surface vertices outside of all tets
    double outside_distance = 0;         // [m] largest distance of such a vertex to the tets
    std::size_t thickened = 0;           // samples of the surface (about 12 a squared cell) that had to be thickened
    std::size_t samples = 0;             // all of these
    std::size_t surface_pieces = 0;      // connected parts of the surface
    std::size_t mesh_pieces = 0;         // connected parts of the mesh
    std::size_t dropped_pieces = 0;      // parts of the mesh that coarse cells had cut off, removed
    double dropped_volume = 0;           // [m^3] of them
    std::size_t separated_vertices = 0;  // added where the mesh touched itself in a point or an edge
    std::size_t pinched_edges = 0;       // edges where it still does
};

struct VolumeMesh {
    TetMesh mesh;  // passes validate(); ordered for refinement
    VolumeMeshReport report;
};

/// Throws InputError for options out of range, a surface without triangles or extent, and one whose inside no lattice
/// of the wanted size finds. Deterministic.
VolumeMesh mesh_volume(const SurfaceMesh& surface, const VolumeMeshOptions& options = {});

/// The report for people: a few lines, with a hint where something was lost.
std::string describe(const VolumeMeshReport& report);

}  // namespace tetfront
