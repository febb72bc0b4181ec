#pragma once
// The bytes behind a DataArray of a .vtu file: base64 or raw, as one block or as zlib blocks, announced by a header.

#include "engine/mesh/vtk_cells.hpp"

#include <string>
#include <string_view>

namespace tetfront {

struct VtkEncoding {
    bool base64 = true;
    bool zlib = false;
    bool big_endian = false;
    VtkType header = VtkType::uint32;  // of the sizes; or uint64
};

/// The most bytes that one array may have after decompression.
inline constexpr std::uint64_t max_vtk_payload = std::uint64_t{1} << 30;

/// Decodes the array that begins at the begin of `text`, which may go on behind it. `fail` must throw.
std::string decode_payload(std::string_view text, const VtkEncoding& encoding, const VtkFail& fail);

}  // namespace tetfront
