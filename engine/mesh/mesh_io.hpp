#pragma once
// Reads triangle surfaces from files, by assimp: OBJ, STL, PLY, OFF, glTF/GLB, FBX, DAE and what else it knows.
//
//     ImportedSurface bunny = read_surface("bunny.obj", 0.01);     // the file is in centimetres
//     std::cerr << describe(bunny.repairs);
//     mesh_volume(bunny.mesh);
//
// All parts of a file are merged, with the transformations of its nodes applied. Axes stay as in the file.

#include "engine/mesh/surface_repair.hpp"
#include "engine/mesh/tet_mesh.hpp"

#include <filesystem>
#include <span>

namespace tetfront {

struct ImportedSurface {
    SurfaceMesh mesh;  // repaired; at least one triangle
    SurfaceRepairs repairs;
};

/// Largest file that is read [bytes]: above, one wants a simplified surface anyway.
inline constexpr std::uintmax_t max_surface_file = std::uintmax_t{1} << 29;
/// Most triangles that are taken.
inline constexpr std::size_t max_surface_triangles = 20'000'000;

/// scale: metres in a unit of the file, > 0. Coordinates are read in single precision. Throws InputError for a file
/// that is missing, unreadable, too large, of an unknown or broken format, without triangles, or with coordinates that
/// are not finite.
ImportedSurface read_surface(const std::filesystem::path& file, double scale = 1);
/// The same of several files, merged as parts of one are: repairs are made on the whole. files: one or more.
ImportedSurface read_surfaces(std::span<const std::filesystem::path> files, double scale = 1);

}  // namespace tetfront
