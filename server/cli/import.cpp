// A first scene for a mesh, an image or a surface that somebody has: at rest, held below, soft enough to be seen to bend.
#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "engine/material/voxel_surface.hpp"
#include "engine/mesh/mesh_io.hpp"
#include "engine/mesh/tet_file.hpp"
#include "engine/scene/json_document.hpp"
#include "engine/scene/scene.hpp"
#include "engine/simulation/shape.hpp"
#include "server/cli/commands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <string>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::ordered_json;

struct ImportOptions {
    std::string file, scene;
    double scale = 0;  // 0: found out
    std::string up;    // empty: found out
    int target_tets = 1000, levels = 2;
    bool force = false;
};

/// What the file holds, in its own units.
struct Content {
    std::string kind;  // key of the scene's mesh
    Eigen::AlignedBox3d box;
    std::set<int> regions;      // of a tet mesh, when there are several
    std::size_t tets = 0;       // of a tet mesh
};

/// UTF-8: what a JSON string can hold.
bool is_text(const std::string& bytes) {
    return Json::accept(Json(bytes).dump(-1, ' ', false, Json::error_handler_t::ignore)) &&
           Json::parse(Json(bytes).dump(-1, ' ', false, Json::error_handler_t::ignore)).get<std::string>() == bytes;
}

bool is_voxel_file(const std::string& file) {
    return std::ranges::any_of(std::array{".nrrd", ".nhdr", ".inr", ".inr.gz"}, [&](const char* end) { return file.ends_with(end); });
}

Content read_content(const std::string& file) {
    Content content;
    if (is_voxel_file(file)) {
        content.kind = "voxels";
        const VoxelImage image = read_voxel_image(file);
        const double cell = voxel_extent(image, {}) / 50;
        for (const Vec3& p : voxel_surface(image, {}, cell).positions) content.box.extend(p);
    } else if (is_tet_file(file)) {
        content.kind = "tets";
        const ImportedTets tets = read_tet_mesh(file);
        for (const Vec3& p : tets.mesh.positions) content.box.extend(p);
        content.tets = tets.mesh.corners.size();
        content.regions = {tets.mesh.region.begin(), tets.mesh.region.end()};
        if (content.regions.size() < 2) content.regions.clear();
    } else {
        content.kind = "surface";
        const ImportedSurface surface = read_surface(file);
        for (const Vec3& p : surface.mesh.positions) content.box.extend(p);
    }
    return content;
}

/// Files say no unit. What would be larger than a house is taken for millimetres, what is still out of proportion is
/// made half a metre long.
double guess_scale(double extent) {
    if (extent >= 0.01 && extent <= 10) return 1;
    if (extent > 10 && extent <= 10'000) return 1e-3;
    return 0.5 / extent;
}

/// Two digits: nobody wants to read E 273141.6 in a scene.
double rounded(double value) {
    if (!(std::abs(value) > 0)) return 0;
    const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 1);
    return std::round(value / unit) * unit;
}

/// As build_model will.
void check_size(const ImportOptions& options, const Content& content, double scale) {
    const double reach = scale * std::max(content.box.min().cwiseAbs().maxCoeff(), content.box.max().cwiseAbs().maxCoeff());
    if (!(reach <= largest_coordinate) || !(scale * content.box.sizes().minCoeff() > 0))
        throw InputError(options.file, "", "reaches " + std::to_string(reach) + " m from the origin, or is flat",
                         "use --scale so that it lies within 1e6 m, or move it");
}

Json first_scene(const ImportOptions& options, const Content& content, double scale, int up) {
    const std::filesystem::path file = std::filesystem::absolute(options.file).lexically_normal();
    const std::filesystem::path folder = std::filesystem::absolute(options.scene).lexically_normal().parent_path();
    const std::filesystem::path relative = file.lexically_relative(folder);
    Json mesh = {{"file", (relative.empty() ? file : relative).generic_string()}, {"scale", scale}};
    if (content.kind != "tets") mesh["target_tets"] = options.target_tets;

    const Eigen::AlignedBox3d box(scale * content.box.min(), scale * content.box.max());
    const double height = box.sizes()[up], extent = box.sizes().maxCoeff();
    // Held by its lowest twentieth. Under its weight a column of this E gets about a fiftieth shorter and bends more.
    Vec3 point = box.center(), normal = Vec3::Zero();
    point[up] = box.min()[up] + 0.05 * height;
    normal[up] = 1;
    constexpr double density = 1000, gravity = 9.81;
    Json material = {{"density", density}, {"young", rounded(25 * density * gravity * extent)}, {"poisson", 0.35}};
    if (!content.regions.empty()) {
        Json list = Json::array();
        for (const int region : content.regions) list.push_back({{"regions", {region}}, {"material", Json::object()}});
        material["regions"] = {{"materials", list}};
    }
    const auto triple = [](const Vec3& v) { return Json{rounded(v[0]), rounded(v[1]), rounded(v[2])}; };
    Json half_space = {{"point", triple(point)}, {"normal", triple(normal)}};
    half_space["point"][static_cast<std::size_t>(up)] = point[up];
    return {{"schema_version", 1},
            {"title", one_line(file.filename().string(), 300)},
            {"up", std::string(1, "xyz"[up])},
            {"mesh", {{content.kind, mesh}}},
            {"levels", options.levels},
            {"material", material},
            {"pins", {{{"half_space", half_space}}}},
            {"damping", {{"mass", 0.3}}},
            {"front", {{"tolerance", 0.03}, {"budget", {{"tets", 2000}}}}}};
}

int import(const ImportOptions& options) {
    if (std::isnan(options.scale)) throw InputError("--scale", "", "is not a number", "use 1e-9 to 1e6");
    std::error_code unknown;  // check_writable says it better
    if (!options.force && std::filesystem::exists(options.scene, unknown))
        throw InputError(options.scene, "", "exists already", "choose another name, or use --force to replace it");
    check_not_same(options.scene, options.file);
    check_writable(options.scene);
    if (!is_text(options.file))
        throw InputError(options.file, "", "has a name that is not UTF-8, which JSON cannot hold", "rename it");
    const Content content = read_content(options.file);
    const double extent = content.box.sizes().maxCoeff();
    const double scale = options.scale > 0 ? options.scale : guess_scale(extent);
    // Models of graphics stand along y, those of engineering and medicine along z.
    const bool graphics = content.kind == "surface" && !options.file.ends_with(".stl") && !options.file.ends_with(".STL");
    const int up = options.up.empty() ? (graphics ? 1 : 2) : options.up[0] - 'x';
    if (static_cast<double>(content.tets) * std::pow(8, options.levels) >= max_leaves)
        throw InputError(options.file, "", "has " + std::to_string(content.tets) + " tets, too many for " +
                             std::to_string(options.levels) + " levels", "use --levels with a smaller number");
    const Json scene = first_scene(options, content, scale, up);
    const std::string text = scene.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    // What is written can be read, and meshed.
    check_size(options, content, scale);
    const Shape shape = make_shape(parse_scene(text, options.scene, std::filesystem::absolute(options.scene).parent_path()));
    write_atomically(options.scene, text);

    std::printf("%s", describe(shape).c_str());
    const Vec3 sizes = scale * content.box.sizes();
    std::printf("%s: %.3g x %.3g x %.3g m at %g m a unit (change mesh.%s.scale), up is %c, held below, E %g Pa\n",
                options.scene.c_str(), sizes[0], sizes[1], sizes[2], scale, content.kind.c_str(), "xyz"[up],
                scene["material"]["young"].get<double>());
    if (content.tets > 0)
        std::printf("its %zu tets are the coarsest level; with %d levels the finest has %zu\n", content.tets, options.levels,
                    content.tets << (3 * options.levels));
    std::printf("Look at it:  tetfront serve %s\n", options.scene.c_str());
    return exit_ok;
}

}  // namespace

void add_import(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("import", "Writes a first scene for a surface, a tet mesh or a voxel image");
    const auto options = std::make_shared<ImportOptions>();
    command->add_option("file", options->file, "Any file that a scene's mesh may name")->required()->type_name("FILE");
    command->add_option("-o,--output", options->scene, "Scene to write")->required()->type_name("SCENE");
    command->add_option("--scale", options->scale, "Metres in a unit of the file; default: guessed from its size")
        ->check(CLI::Range(1e-9, 1e6));
    command->add_option("--up", options->up, "Axis that points up: x, y, z; default: y for graphics formats, else z")
        ->check(CLI::IsMember({"x", "y", "z"}));
    command->add_option("--target-tets", options->target_tets, "Tets of the coarsest level to aim for")
        ->check(CLI::Range(10, 200'000))
        ->capture_default_str();
    command->add_option("--levels", options->levels, "Subdivisions below it")->check(CLI::Range(0, 6))->capture_default_str();
    command->add_flag("--force", options->force, "Replaces an existing scene");
    command->callback([options, &action] { action = [options] { return import(*options); }; });
}

}  // namespace tetfront
