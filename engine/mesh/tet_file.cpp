#include "engine/mesh/tet_file.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/file_bytes.hpp"
#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"
#include "engine/mesh/tet_repair.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numeric>
#include <utility>

namespace tetfront {

namespace {

/// A tet is flat when its volume is below this part of its longest edge cubed: rounding decides its sign.
constexpr double flat = 1e-13;
/// Enough to recognise a format, so that a huge file of something else is refused without reading it.
constexpr std::uintmax_t head_size = 1 << 16;

std::string extension_of(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

/// Throws unless the file begins like one of its format.
void check_head(const std::filesystem::path& file) {
    const std::string head = read_bytes(file, max_tet_file, head_size);
    const std::string extension = extension_of(file);
    Scanner in(head, file.string(), extension == ".vtk" ? '\0' : '#');
    const std::string_view first = in.peek();
    const auto require = [&](bool fits, const char* format, const char* begin) {
        if (!fits)
            throw InputError{file.string(), "line 1", std::string("is not a ") + format + " file",
                             std::string("it should begin with ") + begin};
    };
    if (extension == ".msh") require(first.starts_with("$"), "Gmsh", "$MeshFormat");
    if (extension == ".mesh") require(first.starts_with("MeshVersionFormatted"), "Medit text", "MeshVersionFormatted");
    if (extension == ".vtk") require(head.starts_with("# vtk DataFile"), "VTK legacy", "# vtk DataFile");
    if (extension == ".vtu") require(head.find("<VTKFile") != std::string::npos, "VTK XML", "<VTKFile");
    if (extension == ".node" || extension == ".ele")
        require(!first.empty() && std::isdigit(static_cast<unsigned char>(first[0])) != 0, "TetGen", "a number");
}

std::string tet_name(std::size_t t) { return "tet " + std::to_string(t); }

void orient(TetMesh& mesh, TetRepairs& repairs, const std::string& file) {
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        auto& c = mesh.corners[t];
        const auto x = [&](std::size_t i) -> const Vec3& { return mesh.positions[c[i]]; };
        double longest = 0;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j) longest = std::max(longest, (x(i) - x(j)).norm());
        const double volume = signed_volume(x(0), x(1), x(2), x(3));
        if (!(std::abs(volume) > flat * longest * longest * longest) || !std::isfinite(volume))
            throw InputError{file, tet_name(t.index()), "has no volume", "remove flat tets from the mesh"};
        if (volume > 0) continue;
        std::swap(c[2], c[3]);
        ++repairs.inverted_tets;
    }
}

void refuse_duplicates(const TetMesh& mesh, const std::string& file) {
    std::vector<std::pair<std::array<VertexId, 4>, std::size_t>> sorted;
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        auto c = mesh.corners[t];
        std::sort(c.begin(), c.end());
        sorted.emplace_back(c, t.index());
    }
    std::sort(sorted.begin(), sorted.end());
    std::size_t first = sorted.size();  // the first duplicate in the order of the file
    std::size_t original = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i)
        if (sorted[i].first == sorted[i - 1].first && sorted[i].second < first) {
            first = sorted[i].second;
            original = sorted[i - 1].second;
        }
    if (first < sorted.size())
        throw InputError{file, tet_name(first), "has the same corners as " + tet_name(original), "remove one of them"};
}

}  // namespace

bool is_tet_file(const std::filesystem::path& file) {
    const std::string extension = extension_of(file);
    for (const char* known : {".msh", ".mesh", ".vtk", ".vtu", ".node", ".ele"})
        if (extension == known) return true;
    return false;
}

ImportedTets finish(RawTets raw, const std::string& file, double scale) {
    if (raw.corners.empty())
        throw InputError{file, "", "has no tets", "read a triangle surface as a surface: it will be filled with tets"};
    TetMesh all;
    for (const Vec3& x : raw.positions) {
        all.positions.push_back(scale * x);
        if (!all.positions.back().allFinite())
            throw InputError{file, "", "is too large for the scale", "use a smaller scale"};
    }
    for (const auto& c : raw.corners) {
        std::array<VertexId, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) corners[i] = VertexId{c[i]};
        all.corners.push_back(corners);
    }
    if (std::ranges::any_of(raw.region, [](std::int32_t r) { return r != 0; }))
        all.region.assign(raw.region.begin(), raw.region.end());
    ImportedTets result{keep_tets(all, [](TetId) { return true; }), raw.repairs};
    result.repairs.unused_vertices = all.positions.size() - result.mesh.positions.size() - raw.repairs.welded_vertices;
    orient(result.mesh, result.repairs, file);
    refuse_duplicates(result.mesh, file);
    order_for_refinement(result.mesh);
    try {
        validate(result.mesh);
    } catch (const InputError& error) {
        throw InputError{file, error.where, error.problem, error.remedy};
    }
    return result;
}

ImportedTets read_tet_mesh(const std::filesystem::path& file, double scale) {
    if (!(scale > 0) || !std::isfinite(scale))
        throw InputError{file.string(), "", "the scale " + std::to_string(scale) + " is not usable",
                         "use a number > 0"};
    if (!is_tet_file(file))
        throw InputError{file.string(), "", "has no extension of a tet mesh",
                         "use .msh, .mesh, .vtk, .vtu, .node or .ele"};
    check_head(file);
    const std::string extension = extension_of(file), name = file.string();
    if (extension == ".node" || extension == ".ele") {
        std::filesystem::path node = file, ele = file;
        node.replace_extension(".node");
        ele.replace_extension(".ele");
        check_head(node);
        check_head(ele);
        return finish(
            read_tetgen(read_bytes(node, max_tet_file), node.string(), read_bytes(ele, max_tet_file), ele.string()),
            ele.string(), scale);
    }
    const std::string bytes = read_bytes(file, max_tet_file);
    if (extension == ".msh") return finish(read_gmsh(bytes, name), name, scale);
    if (extension == ".mesh") return finish(read_medit(bytes, name), name, scale);
    if (extension == ".vtk") return finish(read_vtk_legacy(bytes, name), name, scale);
    return finish(read_vtu(bytes, name), name, scale);
}

std::string describe(const TetRepairs& r) {
    std::string text;
    const auto say = [&](std::size_t count, const char* what) {
        if (count) text += std::to_string(count) + " " + what + "\n";
    };
    say(r.inverted_tets, "inverted tets turned around");
    say(r.straightened_tets, "quadratic tets taken by their corners");
    say(r.ignored_cells, "points, lines and faces ignored");
    say(r.unused_vertices, "unused vertices dropped");
    say(r.welded_vertices, "vertices of several pieces welded");
    return text;
}

}  // namespace tetfront
