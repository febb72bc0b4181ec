#include "engine/scene/scene.hpp"

#include "engine/base/error.hpp"
#include "engine/scene/json_reader.hpp"

#include <cmath>

namespace tetfront {

namespace {

constexpr Range coordinate = within(-1e6, 1e6);  // [m]
constexpr double smallest_extent = 1e-6;         // [m] below it volumes underflow
constexpr double max_leaves = 1 << 24;

const Choices<int> axes = {{"x", 0}, {"y", 1}, {"z", 2}};

void check_corners(const JsonObject& box, const Vec3& low, const Vec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        if (high[axis] - low[axis] < smallest_extent) {
            box.place("high").fail(std::string("is not above `low` along ") + "xyz"[axis],
                                   "use high >= low + 1e-6 m along each axis");
        }
    }
}

MeshSpec read_mesh(const JsonValue& value, const std::filesystem::path& directory) {
    const auto [kind, spec] = value.one_of({"box", "surface"});
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
    SurfaceMeshSpec surface;
    const JsonObject o = spec.object({"file", "scale", "target_tets"});
    surface.file = std::filesystem::absolute(directory / o.required("file").line(4096)).lexically_normal();
    o.read("scale", surface.scale, above(0, 1e6));
    o.read("target_tets", surface.target_tets, 10, 200000);
    return surface;
}

ScalarField read_field(const JsonValue& value, const Range& range) {
    ScalarField field;
    if (!value.is_object()) {
        if (!value.is_number())
            value.fail("is " + value.text(),
                       "use a number in " + range.text() + ", or an object with the key linear or exponential");
        field.value = value.number(range);
        return field;
    }
    const auto [kind, spec] = value.one_of({"linear", "exponential"});
    field.kind = kind == "linear" ? ScalarField::Kind::linear : ScalarField::Kind::exponential;
    const JsonObject o = spec.object({"axis", "values", "at"});
    field.axis = o.required("axis").choice(axes);
    const std::vector<JsonValue> values = o.required("values").array(2);
    field.values = {values[0].number(range), values[1].number(range)};
    if (auto at = o.find("at")) {
        const std::vector<JsonValue> ends = at->array(2);
        field.at = {ends[0].number(coordinate), ends[1].number(coordinate)};
        field.at_extent = false;
        if (field.at[1] - field.at[0] < smallest_extent)
            at->fail("is not ascending", "use [a, b] with b >= a + 1e-6 m");
    }
    return field;
}

MaterialSpec read_material(const JsonValue& value) {
    MaterialSpec material;
    const JsonObject o = value.object({"density", "poisson", "young"});
    o.read("density", material.density, above(0, 1e6));
    o.read("poisson", material.poisson, below(0, 0.5));
    if (auto young = o.find("young")) material.young = read_field(*young, above(0, 1e15));
    return material;
}

Region read_region(const JsonValue& value) {
    const auto [kind, spec] = value.one_of({"box", "half_space"});
    if (kind == "box") {
        const JsonObject o = spec.object({"low", "high"});
        const Box box{o.required("low").vector(coordinate), o.required("high").vector(coordinate)};
        check_corners(o, box.low, box.high);
        return box;
    }
    const JsonObject o = spec.object({"point", "normal"});
    const HalfSpace half{o.required("point").vector(coordinate), o.required("normal").vector(coordinate)};
    if (half.normal.norm() < 1e-6) o.required("normal").fail("has no direction", "use a vector of length 1e-6 or more");
    return half;
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
    const int finest = front.order == 2 ? levels - 1 : levels;
    if (front.min_level > std::min(finest, front.max_level)) {
        o.place("min_level")
            .fail("is " + std::to_string(front.min_level),
                  "use an integer in [0, " + std::to_string(std::min(finest, front.max_level)) +
                      "]: not above max_level nor the finest level that this scene can simulate");
    }
    return front;
}

SolverSpec read_solver(const JsonValue& value) {
    SolverSpec solver;
    const JsonObject o =
        value.object({"scheme", "newton_iterations", "newton_tolerance", "cg_tolerance", "cg_iterations"});
    o.read("scheme", solver.scheme, {{"backward_euler", Scheme::backward_euler}, {"midpoint", Scheme::midpoint}});
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

/// The finest level's size is known, or aimed for, before any meshing: say so now rather than run out of memory later.
void check_size(const Scene& scene, const JsonObject& root) {
    double roots = 0;
    if (const auto* box = std::get_if<BoxMeshSpec>(&scene.mesh)) {
        roots = 6.0 * box->cells[0] * box->cells[1] * box->cells[2];
    } else {
        roots = std::get<SurfaceMeshSpec>(scene.mesh).target_tets;
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
                     "pins", "gravity", "forces", "timeline", "damping", "time_step", "front", "solver", "view"});
    static_cast<void>(o.required("schema_version"));

    Scene scene;
    scene.file = document.source;
    scene.name = one_line(scene.file.stem().string(), 100);  // a file's name may be any bytes, a scene's is text
    std::string schema;
    o.read("$schema", schema, 4096);
    o.read("name", scene.name, 100);
    o.read("title", scene.title, 300);
    o.read("up", scene.up, axes);
    scene.mesh = read_mesh(o.required("mesh"), directory);
    o.read("levels", scene.levels, 0, 6);
    check_size(scene, o);
    if (auto material = o.find("material")) scene.material = read_material(*material);
    o.read("estimation", scene.estimation,
           {{"average", Estimation::average}, {"mean_strain", Estimation::mean_strain}});
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
    if (auto damping = o.find("damping")) {
        const JsonObject d = damping->object({"mass", "stiffness"});
        d.read("mass", scene.mass_damping, within(0, 1e6));
        d.read("stiffness", scene.stiffness_damping, within(0, 1e6));
    }
    o.read("time_step", scene.time_step, within(1e-6, 1));
    scene.front = default_front(scene.levels);
    if (auto front = o.find("front")) scene.front = read_front(*front, scene.levels);
    if (auto solver = o.find("solver")) scene.solver = read_solver(*solver);
    if (auto view = o.find("view")) scene.view = read_view(*view);
    return scene;
}

}  // namespace

bool contains(const Region& region, const Vec3& p) {
    if (const auto* box = std::get_if<Box>(&region))
        return (p.array() >= box->low.array()).all() && (p.array() <= box->high.array()).all();
    const auto& half = std::get<HalfSpace>(region);
    return (p - half.point).dot(half.normal) <= 0;
}

Scene load_scene(const std::filesystem::path& file, const std::vector<Override>& overrides) {
    const std::string text = read_text_file(file);
    return parse_scene(text, file.string(), std::filesystem::absolute(file).parent_path(), overrides);
}

Scene parse_scene(std::string_view text, const std::string& source, const std::filesystem::path& directory,
                  const std::vector<Override>& overrides) {
    return read_scene(parse_document(text, source, overrides), directory);
}

}  // namespace tetfront
