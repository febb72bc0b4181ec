#include "engine/scene/scene.hpp"

#include "engine/base/error.hpp"
#include "engine/scene/material_reader.hpp"

#include <cmath>

namespace tetfront {

namespace {

constexpr Range coordinate = coordinate_range;
constexpr double smallest_extent = 1e-6;         // [m] below it volumes underflow
constexpr std::size_t max_surface_files = 100;

MeshSpec read_mesh(const JsonValue& value, const std::filesystem::path& directory) {
    const auto [kind, spec] = value.one_of({"box", "surface", "tets", "voxels"});
    if (kind == "box") {
        BoxMeshSpec box;
        const JsonObject o = spec.object({"low", "high", "cells"});
        o.read("low", box.low, coordinate);
        o.read("high", box.high, coordinate);
        check_corners(o, box.low, box.high);
        if (auto cells = o.find("cells")) {
            const std::vector<JsonValue> counts = cells->array(3);
            for (std::size_t axis = 0; axis < 3; ++axis) box.cells[axis] = counts[axis].integer(1, 256);
        }
        return box;
    }
    if (kind == "tets") {
        TetMeshSpec tets;
        const JsonObject o = spec.object({"file", "scale"});
        tets.file = std::filesystem::absolute(directory / o.required("file").line(4096)).lexically_normal();
        o.read("scale", tets.scale, above(0, 1e6));
        return tets;
    }
    if (kind == "voxels") {
        VoxelMeshSpec voxels;
        const JsonObject o = spec.object({"file", "scale", "labels", "surface_cell", "target_tets"});
        voxels.file = std::filesystem::absolute(directory / o.required("file").line(4096)).lexically_normal();
        o.read("scale", voxels.scale, above(0, 1e6));
        if (auto labels = o.find("labels")) {
            for (const JsonValue& label : labels->array()) voxels.labels.insert(label.integer(-2147483647, 2147483647));
            if (voxels.labels.empty()) labels->fail("is empty; give one label or more", "leave it out for all but 0");
        }
        o.read("surface_cell", voxels.surface_cell, above(0, 1e6));
        o.read("target_tets", voxels.target_tets, 10, 200000);
        return voxels;
    }
    SurfaceMeshSpec surface;
    const JsonObject o = spec.object({"file", "scale", "target_tets"});
    const JsonValue file = o.required("file");
    const std::vector<JsonValue> files = file.is_array() ? file.array() : std::vector{file};
    if (files.empty() || files.size() > max_surface_files)
        file.fail("lists " + std::to_string(files.size()) + " files", "use 1 to " + std::to_string(max_surface_files));
    for (const JsonValue& f : files) surface.files.push_back(std::filesystem::absolute(directory / f.line(4096)).lexically_normal());
    o.read("scale", surface.scale, above(0, 1e6));
    o.read("target_tets", surface.target_tets, 10, 200000);
    return surface;
}

EstimationSpec::Method read_method(const JsonValue& value) {
    using Method = EstimationSpec::Method;
    return value.choice<Method>({{"average", Method::average},
                                 {"mean_strain", Method::mean_strain},
                                 {"isolated", Method::isolated},
                                 {"uniform_stress", Method::uniform_stress}});
}

EstimationSpec read_estimation(const JsonValue& value) {
    EstimationSpec estimation;
    if (!value.is_object()) {
        estimation.method = read_method(value);
        return estimation;
    }
    const JsonObject o = value.object({"method", "sampled", "alphas", "relative_tolerance", "stress_tolerance"});
    if (auto method = o.find("method")) estimation.method = read_method(*method);
    o.read("sampled", estimation.sampled);
    if (auto alphas = o.find("alphas")) {
        estimation.alphas.clear();
        for (const JsonValue& alpha : alphas->array()) {
            const double strain = alpha.number(between(0, 0.49));
            if (!estimation.alphas.empty() && strain <= estimation.alphas.back())
                alpha.fail("is not above the one before it", "use ascending strains");
            estimation.alphas.push_back(strain);
        }
        if (estimation.alphas.size() < 2 || estimation.alphas.size() > 64)
            alphas->fail("has " + std::to_string(estimation.alphas.size()) + " values", "use 2 to 64 of them");
    }
    o.read("relative_tolerance", estimation.relative_tolerance, between(0, 1));
    o.read("stress_tolerance", estimation.stress_tolerance, between(0, 1));
    return estimation;
}

ForceSpec read_force(const JsonValue& value) {
    const JsonObject o = value.object({"region", "force", "start", "end"});
    ForceSpec force;
    force.region = read_region(o.required("region"));
    force.force = o.required("force").vector(within(-1e12, 1e12));
    o.read("start", force.start, within(0, 1e9));
    o.read("end", force.end, within(0, 1e9));
    if (force.end <= force.start) o.place("end").fail("is not after `start`", "use end > start [s]");
    return force;
}

/// Quadratic tets wherever there is a level below the roots for their midpoints.
FrontSpec default_front(int levels) {
    FrontSpec front;
    if (levels == 0) front.order = 1;
    return front;
}

FrontSpec read_front(const JsonValue& value, int levels) {
    FrontSpec front = default_front(levels);
    const JsonObject o = value.object({"order", "tolerance", "budget", "min_level", "max_level"});
    o.read("order", front.order, 1, 2);
    o.read("tolerance", front.tolerance, within(1e-6, 1));
    if (auto budget = o.find("budget")) {
        const JsonObject b = budget->object({"tets", "milliseconds"});
        b.read("tets", front.budget_tets, 1, 1 << 28);
        b.read("milliseconds", front.budget_milliseconds, above(0, 1e6));
    }
    o.read("min_level", front.min_level, 0, 99);
    o.read("max_level", front.max_level, 0, 99);
    if (front.order == 2 && levels == 0) o.place("order").fail("is 2 but `levels` is 0", "use order 1, or levels >= 1");
    const int finest = front.finest(levels);
    if (front.min_level > finest) {
        o.place("min_level")
            .fail("is " + std::to_string(front.min_level),
                  "use an integer in [0, " + std::to_string(finest) +
                      "]: not above max_level nor the finest level that this scene can simulate");
    }
    return front;
}

SolverSpec read_solver(const JsonValue& value) {
    SolverSpec solver;
    const JsonObject o =
        value.object({"scheme", "strain", "start", "newton_iterations", "newton_tolerance", "cg_tolerance", "cg_iterations"});
    o.read("scheme", solver.scheme, {{"backward_euler", Scheme::backward_euler}, {"midpoint", Scheme::midpoint}, {"bdf2", Scheme::bdf2}, {"explicit", Scheme::explicit_euler}, {"auto", Scheme::automatic}});
    o.read("start", solver.start, {{"rest_shape", Start::rest_shape}, {"equilibrium", Start::equilibrium}});
    o.read("strain", solver.strain, {{"corotated", StrainMeasure::corotated}, {"green", StrainMeasure::green}});
    o.read("newton_iterations", solver.newton_iterations, 1, 50);
    o.read("newton_tolerance", solver.newton_tolerance, between(0, 1));
    o.read("cg_tolerance", solver.cg_tolerance, between(0, 1));
    o.read("cg_iterations", solver.cg_iterations, 1, 1000000);
    return solver;
}

std::vector<TimelineEvent> read_timeline(const JsonValue& value, int pins) {
    std::vector<TimelineEvent> timeline;
    for (const JsonValue& item : value.array()) {
        const JsonObject o = item.object({"time", "gravity", "release"});
        TimelineEvent event{.time = o.required("time").number(within(0, 1e9)), .gravity = {}, .release = {}};
        if (auto gravity = o.find("gravity")) event.gravity = gravity->vector(within(-1e4, 1e4));
        if (auto release = o.find("release")) {
            event.release = release->integer(0, 1'000'000);
            if (*event.release >= pins)
                release->fail("is " + std::to_string(*event.release) + " but there are " + std::to_string(pins) + " pins",
                              "use the number of an entry of `pins`, counted from 0");
        }
        timeline.push_back(event);
    }
    return timeline;
}

GroundSpec read_ground(const JsonValue& value) {
    GroundSpec ground;
    const JsonObject o = value.object({"height", "friction"});
    o.read("height", ground.height, coordinate);
    o.read("friction", ground.friction, within(0, 10));
    return ground;
}

/// The finest level's size is known, or aimed for, before any meshing: say so now rather than run out of memory later.
void check_size(const Scene& scene, const JsonObject& root) {
    double roots = 0;
    if (const auto* box = std::get_if<BoxMeshSpec>(&scene.mesh)) {
        roots = 6.0 * box->cells[0] * box->cells[1] * box->cells[2];
    } else if (const auto* surface = std::get_if<SurfaceMeshSpec>(&scene.mesh)) {
        roots = surface->target_tets;
    } else if (const auto* voxels = std::get_if<VoxelMeshSpec>(&scene.mesh)) {
        roots = voxels->target_tets;
    }
    const double leaves = roots * std::pow(8, scene.levels);
    if (leaves < max_leaves) return;
    root.place("levels").fail("makes " + std::to_string(static_cast<long long>(leaves)) + " tets of " +
                                  std::to_string(static_cast<long long>(roots)) + " roots and " +
                                  std::to_string(scene.levels) + " levels",
                              "use fewer cells or levels: the finest level must have less than 16777216 tets");
}

Scene read_scene(const JsonDocument& document, const std::filesystem::path& directory) {
    const JsonValue root(document);
    // First, so that a file of another version is told so, rather than that one of its keys is unknown.
    if (auto version = root.member("schema_version")) static_cast<void>(version->integer(1, 1));
    const JsonObject o =
        root.object({"$schema", "schema_version", "name", "title", "up", "mesh", "levels", "material", "estimation",
                     "pins", "gravity", "forces", "timeline", "ground", "damping", "time_step", "front", "solver", "view"});
    static_cast<void>(o.required("schema_version"));

    Scene scene;
    scene.file = document.source;
    scene.name = one_line(scene.file.stem().string(), 100);  // a file's name may be any bytes, a scene's is text
    std::string schema;
    o.read("$schema", schema, 4096);
    o.read("name", scene.name, 100);
    o.read("title", scene.title, 300);
    if (auto up = o.find("up")) scene.up = read_axis(*up);
    scene.mesh = read_mesh(o.required("mesh"), directory);
    o.read("levels", scene.levels, 0, 6);
    check_size(scene, o);
    ElasticSpec base;
    if (auto damping = o.find("damping")) read_damping(*damping, base, directory);
    scene.material.materials = {base};
    if (auto material = o.find("material")) scene.material = read_material(*material, base, directory);
    if (auto estimation = o.find("estimation")) scene.estimation = read_estimation(*estimation);
    if (auto pins = o.find("pins")) {
        for (const JsonValue& pin : pins->array()) scene.pins.push_back(read_region(pin));
    }
    scene.gravity = Vec3::Zero();
    scene.gravity[scene.up] = -9.81;
    o.read("gravity", scene.gravity, within(-1e4, 1e4));
    if (auto forces = o.find("forces")) {
        for (const JsonValue& force : forces->array()) scene.forces.push_back(read_force(force));
    }
    if (auto timeline = o.find("timeline"))
        scene.timeline = read_timeline(*timeline, static_cast<int>(scene.pins.size()));
    if (auto ground = o.find("ground")) scene.ground = read_ground(*ground);
    o.read("time_step", scene.time_step, within(1e-6, 1));
    scene.front = default_front(scene.levels);
    if (auto front = o.find("front")) scene.front = read_front(*front, scene.levels);
    if (auto solver = o.find("solver")) scene.solver = read_solver(*solver);
    if (scene.solver.start == Start::equilibrium && scene.pins.empty())
        o.place("solver").fail("has `start` equilibrium but nothing is pinned", "add `pins`, or start from rest_shape");
    if (auto view = o.find("view")) scene.view = read_view(*view);
    return scene;
}

}  // namespace

int FrontSpec::finest(int depth) const { return std::max(0, std::min(max_level, order == 2 ? depth - 1 : depth)); }

Scene load_scene(const std::filesystem::path& file, const std::vector<Override>& overrides) {
    const std::string text = read_text_file(file);
    return parse_scene(text, file.string(), std::filesystem::absolute(file).parent_path(), overrides);
}

Scene parse_scene(std::string_view text, const std::string& source, const std::filesystem::path& directory,
                  const std::vector<Override>& overrides) {
    return read_scene(parse_document(text, source, overrides), directory);
}

}  // namespace tetfront
