// TetGen's pair of text files: points in .node, tets in .ele; numbered from 0 or from 1. `#` begins a comment.

#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"

#include <algorithm>

namespace tetfront {

namespace {

/// More attributes than that are nonsense, and would make a short file claim many numbers.
constexpr std::int64_t max_attributes = 1000;

}  // namespace

RawTets read_tetgen(std::string_view node_bytes, const std::string& node_file, std::string_view ele_bytes,
                    const std::string& ele_file) {
    RawTets raw;
    Scanner nodes(node_bytes, node_file, '#');
    const std::size_t node_count = nodes.count("points", 2 * 4);
    if (nodes.integer("the dimension", 2, 3) != 3) nodes.fail("is two-dimensional", "use a mesh with tetrahedra");
    const std::int64_t attributes = nodes.integer("the number of attributes", 0, max_attributes);
    const std::int64_t markers = nodes.integer("the number of markers", 0, 1);
    std::int64_t first = 0;
    for (std::size_t i = 0; i < node_count; ++i) {
        const std::int64_t number = nodes.integer("a point's number");
        if (i == 0) {
            first = number;
            if (first != 0 && first != 1)
                nodes.fail("its first point has the number " + std::to_string(first), "number from 0 or 1");
        } else if (number != first + static_cast<std::int64_t>(i)) {
            nodes.fail("point " + std::to_string(number) + " is out of order", "number the points one after another");
        }
        const double x = nodes.real("a coordinate"), y = nodes.real("a coordinate"), z = nodes.real("a coordinate");
        raw.positions.emplace_back(x, y, z);
        for (std::int64_t k = 0; k < attributes; ++k) nodes.real("an attribute");
        for (std::int64_t k = 0; k < markers; ++k) nodes.integer("a marker");
    }

    Scanner tets(ele_bytes, ele_file, '#');
    const std::size_t tet_count = tets.count("tets", 2 * 5);
    const std::int64_t corners_each = tets.integer("4 or 10 nodes a tet", 4, 10);
    if (corners_each != 4 && corners_each != 10) tets.fail("a tet has 4 or 10 nodes", "the file is broken");
    const std::int64_t tet_attributes = tets.integer("the number of attributes", 0, max_attributes);
    for (std::size_t i = 0; i < tet_count; ++i) {
        tets.integer("a tet's number");
        std::array<std::int32_t, 4> corners{};
        for (std::int64_t k = 0; k < corners_each; ++k) {
            const std::int64_t v = tets.integer("a point", first, first + static_cast<std::int64_t>(node_count) - 1);
            if (k < 4) corners[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(v - first);
        }
        raw.corners.push_back(corners);
        std::int32_t region = 0;
        for (std::int64_t k = 0; k < tet_attributes; ++k) {
            const double attribute = tets.real("an attribute");
            if (k > 0) continue;
            if (attribute != static_cast<double>(
                                 static_cast<std::int32_t>(std::min(std::max(attribute, -2147483648.0), 2147483647.0))))
                tets.fail("the first attribute of a tet is its region and must be a whole number",
                          "remove or renumber it");
            region = static_cast<std::int32_t>(attribute);
        }
        raw.region.push_back(region);
    }
    if (corners_each == 10) raw.repairs.straightened_tets = tet_count;
    return raw;
}

}  // namespace tetfront
