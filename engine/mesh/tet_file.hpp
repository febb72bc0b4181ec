#pragma once
// Reads tet meshes from files:
//
//     .msh          Gmsh 1, 2.2 and 4.1, text and binary      region: physical group
//     .mesh         Medit, text                               region: reference
//     .vtk          VTK legacy, text and binary               region: cell data
//     .vtu          VTK XML: text, base64 or appended, either byte order, zlib or not; region: cell data
//     .node .ele    TetGen (name either one)                  region: first attribute
//
//     ImportedTets liver = read_tet_mesh("liver.msh", 0.001);      // the file is in millimetres
//     std::cerr << describe(liver.repairs);
//     TetTree tree(liver.mesh, 2);
//
// Points, lines and faces in the file are ignored, quadratic tets are taken by their corners, and files with
// hexahedra, prisms or pyramids are refused. Of VTK's cell data the array that is named like a region (`region`,
// `material`, `MaterialIDs`, `gmsh:physical`, `medit:ref`, `CellEntityIds`, `attribute`, `part`...) is taken.

#include "engine/mesh/imported_tets.hpp"

#include <filesystem>
#include <string>

namespace tetfront {

/// Largest file that is read [bytes].
inline constexpr std::uintmax_t max_tet_file = std::uintmax_t{1} << 29;

/// The extension is one of those above.
bool is_tet_file(const std::filesystem::path& file);

/// scale: metres in a unit of the file, > 0. Throws InputError with file and line for whatever is broken, and with the
/// tet's number (from 0, in the order of the file) for one that is flat or a duplicate, or that overlaps another one.
ImportedTets read_tet_mesh(const std::filesystem::path& file, double scale = 1);

/// One line for each kind of repair that happened; empty when there is nothing to say.
std::string describe(const TetRepairs& repairs);

}  // namespace tetfront
