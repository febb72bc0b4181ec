#pragma once
// How good tets are for a surface: what mesh_volume did and what came of it.
//
//     VolumeMeshReport report;
//     measure(surface, SurfaceBvh(surface), mesh, report);
//     std::cout << describe(report);

#include "engine/mesh/tet_mesh.hpp"
#include "engine/mesh/winding_number.hpp"

#include <array>
#include <string>

namespace tetfront {

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

double tet_volume(const TetMesh& mesh, TetId t);  // [m^3]

/// By the divergence theorem [m^3], seen from the area-weighted middle: exact for a closed surface, and for an open one as
/// if its rim were joined to the middle.
double enclosed_volume(const SurfaceMesh& surface);
double area(const SurfaceMesh& surface);  // [m^2]

/// Sets counts, angles, volumes and what lies outside. bvh: of the surface.
void measure(const SurfaceMesh& surface, const SurfaceBvh& bvh, const TetMesh& mesh, VolumeMeshReport& report);

/// The report for people: a few lines, with a hint where something was lost.
std::string describe(const VolumeMeshReport& report);

}  // namespace tetfront
