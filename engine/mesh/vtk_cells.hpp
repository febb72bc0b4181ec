#pragma once
// What both VTK formats share: numbers of any of VTK's types, cells by type and offset, and which cell data is a
// region.

#include "engine/mesh/tet_readers.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

enum class VtkType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

std::size_t size_of(VtkType type);
bool is_integer(VtkType type);
/// One value of the type at `from`, which has size_of(type) bytes.
double load_real(const char* from, VtkType type, bool big_endian);
/// The same for integer types; uint64 above 2^63 becomes negative.
std::int64_t load_integer(const char* from, VtkType type, bool big_endian);

/// One-component cell data of whole numbers.
struct VtkCellData {
    std::string name;
    std::vector<std::int64_t> values;  // [cells]
};

/// The array that is named like a region; without one, none. The best name wins, then the first array.
const VtkCellData* find_region(const std::vector<VtkCellData>& data);

/// Reports what is wrong; does not return.
using VtkFail = std::function<void(const std::string& problem, const std::string& remedy)>;

/// Appends the tets of a block of cells. Cell i has the corners connectivity[end[i-1] .. end[i]), relative to the
/// block's points, which are raw.positions from `first_point` on. region: [cells] or empty.
void append_cells(RawTets& raw, std::size_t first_point, const std::vector<std::int64_t>& connectivity,
                  const std::vector<std::int64_t>& end, const std::vector<std::int64_t>& types,
                  const std::vector<std::int64_t>& region, const VtkFail& fail);

}  // namespace tetfront
