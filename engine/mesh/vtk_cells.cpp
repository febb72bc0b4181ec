#include "engine/mesh/vtk_cells.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/scanner.hpp"

#include <array>
#include <cctype>

namespace tetfront {

namespace {

/// In the order of preference, lower case without punctuation.
constexpr std::array<std::string_view, 14> region_names = {
    "region",   "regions",       "regionid",  "material", "materialid", "materialids", "gmshphysical",
    "meditref", "cellentityids", "attribute", "part",     "partid",     "label",       "labels"};

std::string simplified(std::string_view name) {
    std::string out;
    for (char c : name)
        if (std::isalnum(static_cast<unsigned char>(c)))
            out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return out;
}

/// Nodes of VTK's fixed-size cell types that are no volumes; 0: another type.
bool is_flat(std::int64_t type) {
    // vertices, lines, triangles, strips, polygons, pixels, quads, and the quadratic ones of them
    for (std::int64_t flat : {1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36})
        if (type == flat) return true;
    return false;
}

}  // namespace

std::size_t size_of(VtkType type) {
    switch (type) {
        case VtkType::int8:
        case VtkType::uint8:
            return 1;
        case VtkType::int16:
        case VtkType::uint16:
            return 2;
        case VtkType::int32:
        case VtkType::uint32:
        case VtkType::float32:
            return 4;
        case VtkType::int64:
        case VtkType::uint64:
        case VtkType::float64:
            return 8;
    }
    ENSURE(false, "type ", static_cast<int>(type));
}

bool is_integer(VtkType type) { return type != VtkType::float32 && type != VtkType::float64; }

std::int64_t load_integer(const char* from, VtkType type, bool big_endian) {
    switch (type) {
        case VtkType::int8:
            return load<std::int8_t>(from, big_endian);
        case VtkType::uint8:
            return load<std::uint8_t>(from, big_endian);
        case VtkType::int16:
            return load<std::int16_t>(from, big_endian);
        case VtkType::uint16:
            return load<std::uint16_t>(from, big_endian);
        case VtkType::int32:
            return load<std::int32_t>(from, big_endian);
        case VtkType::uint32:
            return load<std::uint32_t>(from, big_endian);
        default:
            return load<std::int64_t>(from, big_endian);
    }
}

double load_real(const char* from, VtkType type, bool big_endian) {
    if (type == VtkType::float32) return static_cast<double>(load<float>(from, big_endian));
    if (type == VtkType::float64) return load<double>(from, big_endian);
    return static_cast<double>(load_integer(from, type, big_endian));
}

const VtkCellData* find_region(const std::vector<VtkCellData>& data) {
    for (std::string_view name : region_names)
        for (const VtkCellData& array : data)
            if (simplified(array.name) == name) return &array;
    return nullptr;
}

void append_cells(RawTets& raw, std::size_t first_point, const std::vector<std::int64_t>& connectivity,
                  const std::vector<std::int64_t>& end, const std::vector<std::int64_t>& types,
                  const std::vector<std::int64_t>& region, const VtkFail& fail) {
    if (end.size() != types.size())
        fail("has " + std::to_string(end.size()) + " cells and " + std::to_string(types.size()) + " cell types",
             "the file is broken: export it again");
    const auto points = static_cast<std::int64_t>(raw.positions.size() - first_point);
    const std::int64_t size = static_cast<std::int64_t>(connectivity.size());
    for (std::size_t cell = 0; cell < end.size(); ++cell) {
        const std::string name = "cell " + std::to_string(cell);
        const std::int64_t begin = cell == 0 ? 0 : end[cell - 1];
        if (end[cell] < begin || end[cell] > size)
            fail(name + " ends at " + std::to_string(end[cell]) + " of a connectivity of " + std::to_string(size),
                 "the file is broken: export it again");
        const std::int64_t type = types[cell];
        const bool linear = type == 10, quadratic = type == 24;
        if (!linear && !quadratic) {
            if (!is_flat(type) && type != 0)
                fail(name + " has the type " + std::to_string(type) + ", which is no tet",
                     "split volumes into tetrahedra");
            ++raw.repairs.ignored_cells;
            continue;
        }
        if (end[cell] - begin != (linear ? 4 : 10))
            fail(name + " has " + std::to_string(end[cell] - begin) + " points", "a tet has 4, a quadratic one 10");
        std::array<std::int32_t, 4> corners{};
        for (std::size_t i = 0; i < 4; ++i) {
            const std::int64_t v = connectivity[static_cast<std::size_t>(begin) + i];
            if (v < 0 || v >= points)
                fail(name + " refers to point " + std::to_string(v),
                     "points are numbered 0 to " + std::to_string(points - 1));
            corners[i] = static_cast<std::int32_t>(first_point + static_cast<std::size_t>(v));
        }
        const std::int64_t r = region.empty() ? 0 : region[cell];
        if (r < INT32_MIN || r > INT32_MAX)
            fail("the region " + std::to_string(r) + " of " + name + " is out of range", "renumber it");
        raw.corners.push_back(corners);
        raw.region.push_back(static_cast<std::int32_t>(r));
        raw.repairs.straightened_tets += quadratic ? 1 : 0;
    }
}

}  // namespace tetfront
