// Medit .mesh (INRIA), text: sections of a keyword, a count and lines of numbers, the last of which is a reference.

#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"

#include <cctype>

namespace tetfront {

namespace {

/// Sections that are skipped, with the numbers of an entry: whole ones, then reals.
struct Skipped {
    std::string_view name;
    std::size_t numbers;
    bool cells;  // count its entries as ignored cells
};
constexpr Skipped skipped[] = {
    {"Edges", 3, true},          {"EdgesP2", 4, true},           {"Triangles", 4, true}, {"TrianglesP2", 7, true},
    {"Quadrilaterals", 5, true}, {"Corners", 1, false},          {"Ridges", 1, false},   {"RequiredVertices", 1, false},
    {"RequiredEdges", 1, false}, {"RequiredTriangles", 1, false}};

}  // namespace

RawTets read_medit(std::string_view bytes, const std::string& file) {
    Scanner in(bytes, file, '#');
    RawTets raw;
    bool vertices = false;
    const auto is_number = [](std::string_view word) {
        return std::isdigit(static_cast<unsigned char>(word[0])) || word[0] == '-' || word[0] == '+' || word[0] == '.';
    };
    if (in.word("MeshVersionFormatted") != "MeshVersionFormatted")
        in.fail("should begin with MeshVersionFormatted", "binary .meshb files: save them as text");
    in.integer("a version", 1, 4);
    while (!in.at_end()) {
        const std::string section(in.word("a section"));
        if (section == "End") break;
        if (section == "Dimension") {
            if (in.integer("the dimension", 2, 3) != 3) in.fail("is two-dimensional", "use a mesh with tetrahedra");
        } else if (section == "Vertices") {
            if (vertices) in.fail("has Vertices twice", "the file is broken: export it again");
            vertices = true;
            const std::size_t n = in.count("vertices", 8);
            for (std::size_t i = 0; i < n; ++i) {
                const double x = in.real("a coordinate"), y = in.real("a coordinate"), z = in.real("a coordinate");
                raw.positions.emplace_back(x, y, z);
                in.integer("a reference");
            }
        } else if (section == "Tetrahedra" || section == "TetrahedraP2") {
            const bool quadratic = section == "TetrahedraP2";
            const std::size_t n = in.count("tetrahedra", quadratic ? 22 : 10);
            for (std::size_t i = 0; i < n; ++i) {
                std::array<std::int32_t, 4> corners{};
                for (std::size_t k = 0; k < (quadratic ? 10U : 4U); ++k) {
                    const std::int64_t v = in.integer("a vertex", 1, static_cast<std::int64_t>(raw.positions.size()));
                    if (k < 4) corners[k] = static_cast<std::int32_t>(v - 1);
                }
                raw.corners.push_back(corners);
                raw.region.push_back(static_cast<std::int32_t>(in.integer("a reference", INT32_MIN, INT32_MAX)));
            }
            if (quadratic) raw.repairs.straightened_tets += n;
        } else if (section == "Hexahedra" || section == "Prisms" || section == "Pyramids") {
            if (in.count("cells", 2) > 0) in.fail("has " + section, "split them into tetrahedra");
        } else {
            const Skipped* known = nullptr;
            for (const Skipped& s : skipped)
                if (s.name == section) known = &s;
            if (known) {
                const std::size_t n = in.count(section, 2 * known->numbers);
                for (std::size_t i = 0; i < n * known->numbers; ++i) in.integer("a number");
                if (known->cells) raw.repairs.ignored_cells += n;
            } else if (std::isalpha(static_cast<unsigned char>(section[0]))) {
                // Normals, tangents, extensions: up to the next keyword.
                while (!in.at_end() && is_number(in.peek())) in.word("a number");
            } else {
                in.fail("a section is expected", "the file is broken: export it again");
            }
        }
    }
    if (!vertices) in.fail("has no Vertices", "the file is cut off or broken: export it again");
    return raw;
}

}  // namespace tetfront
