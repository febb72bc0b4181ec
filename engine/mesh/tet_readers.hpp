#pragma once
// The readers behind read_tet_mesh(), one for each family of formats: from the bytes of a file to what the file says.
// finish() then makes a TetMesh of it. All throw InputError and nothing else, whatever the bytes are.
//
//     RawTets raw = read_gmsh(bytes, "liver.msh");
//     ImportedTets liver = finish(std::move(raw), "liver.msh", 0.001);

#include "engine/mesh/imported_tets.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

/// Tets as the file has them: of any orientation, vertices perhaps unused.
struct RawTets {
    std::vector<Vec3> positions;                       // in the file's unit, finite
    std::vector<std::array<std::int32_t, 4>> corners;  // valid indices into positions
    std::vector<std::int32_t> region;                  // [corners] or empty
    TetRepairs repairs;                                // straightened, ignored, welded
};

RawTets read_gmsh(std::string_view bytes, const std::string& file);
RawTets read_medit(std::string_view bytes, const std::string& file);
RawTets read_vtk_legacy(std::string_view bytes, const std::string& file);
RawTets read_vtu(std::string_view bytes, const std::string& file);
RawTets read_tetgen(std::string_view node_bytes, const std::string& node_file, std::string_view ele_bytes,
                    const std::string& ele_file);

/// Scales, turns inverted tets, drops unused vertices, and refuses flat, double and overlapping tets.
ImportedTets finish(RawTets raw, const std::string& file, double scale);

}  // namespace tetfront
