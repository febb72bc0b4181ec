#include "engine/scene/material_reader.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tetfront {

namespace {

constexpr double smallest_extent = 1e-6;  // [m] below it volumes underflow

constexpr Range density_range = above(0, 1e6), young_range = above(0, 1e15), poisson_range = below(0, 0.5),
                scale_range = above(0, 1e6), damping_range = within(0, 1e6);

std::filesystem::path read_path(const JsonValue& value, const std::filesystem::path& directory) {
    return std::filesystem::absolute(directory / value.line(4096)).lexically_normal();
}

GradientSpec read_gradient(const JsonValue& value, Interpolation interpolation, const Range& range) {
    GradientSpec gradient;
    gradient.interpolation = interpolation;
    const JsonObject o = value.object({"axis", "values", "at"});
    gradient.axis = read_axis(o.required("axis"));
    const std::vector<JsonValue> values = o.required("values").array(2);
    for (std::size_t i = 0; i < 2; ++i) {
        gradient.values[i] = values[i].number(range);
        if (interpolation == Interpolation::exponential && gradient.values[i] <= 0)
            values[i].fail("is " + values[i].text(), "use a number above 0 for an exponential gradient");
    }
    if (auto at = o.find("at")) {
        const std::vector<JsonValue> ends = at->array(2);
        gradient.at = {ends[0].number(coordinate_range), ends[1].number(coordinate_range)};
        if ((*gradient.at)[1] - (*gradient.at)[0] < smallest_extent)
            at->fail("is not ascending", "use [a, b] with b >= a + 1e-6 m");
    }
    return gradient;
}

VoxelsSpec read_voxels(const JsonValue& value, const std::filesystem::path& directory) {
    const JsonObject o = value.object({"file", "scale", "factor", "sampling"});
    VoxelsSpec voxels;
    voxels.file = read_path(o.required("file"), directory);
    o.read("scale", voxels.scale, above(0, 1e6));
    o.read("factor", voxels.factor, above(0, 1e15));
    o.read("sampling", voxels.sampling, {{"linear", VoxelSampling::linear}, {"nearest", VoxelSampling::nearest}});
    return voxels;
}

ScalarSpec read_scalar(const JsonValue& value, const Range& range, const std::filesystem::path& directory) {
    if (value.is_number()) return value.number(range);
    if (!value.is_object())
        value.fail("is " + value.text(), "use a number in " + range.text() +
                                             ", or an object with the key linear, exponential, voxels or per_tet");
    const auto [kind, spec] = value.one_of({"linear", "exponential", "voxels", "per_tet"});
    if (kind == "voxels") return read_voxels(spec, directory);
    if (kind == "per_tet") {
        PerTetSpec list{.values = {}, .pointer = spec.pointer()};
        for (const JsonValue& each : spec.array()) list.values.push_back(each.number(range));
        if (list.values.empty()) spec.fail("is empty", "give one value for each tet of the coarsest level");
        return list;
    }
    return read_gradient(spec, kind == "linear" ? Interpolation::linear : Interpolation::exponential, range);
}

Orthotropic read_orthotropic(const JsonValue& value) {
    const JsonObject o = value.object({"young", "poisson", "shear", "axes"});
    Orthotropic constants;
    constants.young = o.required("young").vector(young_range);
    constants.poisson = o.required("poisson").vector(between(-10, 10));
    constants.shear = o.required("shear").vector(young_range);
    if (auto axes = o.find("axes")) {
        const std::vector<JsonValue> given = axes->array(2);
        const Vec3 first = given[0].vector(coordinate_range), second = given[1].vector(coordinate_range);
        const double sine = first.cross(second).norm() / (first.norm() * second.norm());
        if (!(sine > 1e-6)) axes->fail("has no two directions", "use two vectors that are not parallel");
        constants.frame.col(0) = first.normalized();
        constants.frame.col(2) = first.cross(second).normalized();
        constants.frame.col(1) = constants.frame.col(2).cross(constants.frame.col(0));
    }
    try {
        static_cast<void>(orthotropic(constants));
    } catch (const InputError& error) {
        o.place(error.where).fail(error.problem, error.remedy);
    }
    return constants;
}

void read_elastic(const JsonObject& o, ElasticSpec& material, const std::filesystem::path& directory) {
    const auto read = [&](std::string_view key, ScalarSpec& target, const Range& range) {
        if (auto found = o.find(key)) target = read_scalar(*found, range, directory);
    };
    read("density", material.density, density_range);
    read("poisson", material.poisson, poisson_range);
    read("young", material.young, young_range);
    read("scale", material.scale, scale_range);
    if (auto found = o.find("damping")) read_damping(*found, material, directory);
    if (o.find("young") || o.find("poisson")) material.orthotropic.reset();
    if (auto found = o.find("orthotropic")) {
        if (o.find("young") || o.find("poisson"))
            found->fail("stands beside `young` or `poisson`", "use either orthotropic, or young and poisson");
        material.orthotropic = read_orthotropic(*found);
    }
    if (!material.orthotropic && o.find("scale"))
        o.required("scale").fail("has nothing to scale", "use it with `orthotropic`; for others change `young`");
}

/// Appends a material that differs from `base` as `value` says; returns its zone.
int add_material(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory,
                 MaterialSpec& spec) {
    ElasticSpec material = base;
    read_elastic(value.object({"density", "poisson", "young", "orthotropic", "scale", "damping"}), material, directory);
    spec.materials.push_back(std::move(material));
    return static_cast<int>(spec.materials.size()) - 1;
}

LayersSpec read_layers(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory,
                       MaterialSpec& spec) {
    const JsonObject o = value.object({"axis", "boundaries", "materials"});
    LayersSpec layers{.axis = read_axis(o.required("axis")), .boundaries = {}};
    for (const JsonValue& each : o.required("boundaries").array()) {
        const double boundary = each.number(coordinate_range);
        if (!layers.boundaries.empty() && !(boundary > layers.boundaries.back()))
            each.fail("is not above the one before it", "use ascending coordinates");
        layers.boundaries.push_back(boundary);
    }
    spec.materials.clear();
    const JsonValue materials = o.required("materials");
    for (const JsonValue& each : materials.array()) add_material(each, base, directory, spec);
    if (spec.materials.size() != layers.boundaries.size() + 1)
        materials.fail("has " + std::to_string(spec.materials.size()) + " layers for " +
                           std::to_string(layers.boundaries.size()) + " boundaries",
                       "use one more material than boundaries");
    return layers;
}

ShapesSpec read_shapes(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory,
                       MaterialSpec& spec) {
    ShapesSpec shapes;
    for (const JsonValue& each : value.array()) {
        const JsonObject o = each.object({"region", "material", "priority"});
        ZoneShape shape;
        shape.region = read_region(o.required("region"));
        shape.zone = add_material(o.required("material"), base, directory, spec);
        o.read("priority", shape.priority, -1000000, 1000000);
        shapes.shapes.push_back(shape);
    }
    return shapes;
}

/// [{"labels": [1, 2], "material": {...}}, ...]: zone of each number.
template <class Number>
std::map<Number, int> read_zone_map(const JsonValue& list, std::string_view key, const ElasticSpec& base,
                                    const std::filesystem::path& directory, MaterialSpec& spec) {
    std::map<Number, int> zones;
    for (const JsonValue& each : list.array()) {
        const JsonObject o = each.object({key, "material"});
        const int zone = add_material(o.required("material"), base, directory, spec);
        for (const JsonValue& number : o.required(key).array()) {
            if (!zones.emplace(number.integer(-2147483647, 2147483647), zone).second)
                number.fail("has a material already", "name each number once");
        }
    }
    return zones;
}

std::optional<int> read_otherwise(const JsonObject& o, const ElasticSpec& base, const std::filesystem::path& directory,
                                  MaterialSpec& spec) {
    const auto found = o.find("otherwise");
    return found ? std::optional(add_material(*found, base, directory, spec)) : std::nullopt;
}

LabelsSpec read_labels(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory,
                       MaterialSpec& spec) {
    const JsonObject o = value.object({"file", "scale", "materials", "otherwise"});
    LabelsSpec labels;
    labels.file = read_path(o.required("file"), directory);
    o.read("scale", labels.scale, above(0, 1e6));
    spec.materials.clear();
    labels.zone_of_label = read_zone_map<long long>(o.required("materials"), "labels", base, directory, spec);
    labels.otherwise = read_otherwise(o, base, directory, spec);
    if (spec.materials.empty()) o.required("materials").fail("is empty", "give a material for each label");
    return labels;
}

RegionsSpec read_regions(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory,
                         MaterialSpec& spec) {
    const JsonObject o = value.object({"materials", "otherwise"});
    RegionsSpec regions;
    spec.materials.clear();
    regions.zone_of_region = read_zone_map<int>(o.required("materials"), "regions", base, directory, spec);
    regions.otherwise = read_otherwise(o, base, directory, spec);
    if (spec.materials.empty()) o.required("materials").fail("is empty", "give a material for each region");
    return regions;
}

}  // namespace

int read_axis(const JsonValue& value) { return value.choice<int>({{"x", 0}, {"y", 1}, {"z", 2}}); }

void check_corners(const JsonObject& box, const Vec3& low, const Vec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        if (high[axis] - low[axis] < smallest_extent) {
            box.place("high").fail(std::string("is not above `low` along ") + "xyz"[axis],
                                   "use high >= low + 1e-6 m along each axis");
        }
    }
}

Region read_region(const JsonValue& value) {
    const auto [kind, spec] = value.one_of({"box", "half_space", "sphere"});
    if (kind == "box") {
        const JsonObject o = spec.object({"low", "high"});
        const Box box{o.required("low").vector(coordinate_range), o.required("high").vector(coordinate_range)};
        check_corners(o, box.low, box.high);
        return box;
    }
    if (kind == "sphere") {
        const JsonObject o = spec.object({"centre", "radius"});
        return Sphere{o.required("centre").vector(coordinate_range), o.required("radius").number(above(0, 1e6))};
    }
    const JsonObject o = spec.object({"point", "normal"});
    const HalfSpace half{o.required("point").vector(coordinate_range), o.required("normal").vector(coordinate_range)};
    if (half.normal.norm() < 1e-6) o.required("normal").fail("has no direction", "use a vector of length 1e-6 or more");
    return half;
}

void read_damping(const JsonValue& value, ElasticSpec& material, const std::filesystem::path& directory) {
    const JsonObject o = value.object({"mass", "stiffness"});
    if (auto mass = o.find("mass")) material.mass_damping = read_scalar(*mass, damping_range, directory);
    if (auto stiffness = o.find("stiffness"))
        material.stiffness_damping = read_scalar(*stiffness, damping_range, directory);
}

MaterialSpec read_material(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory) {
    const JsonObject o = value.object({"density", "poisson", "young", "orthotropic", "scale", "damping", "layers",
                                       "shapes", "labels", "regions"});
    ElasticSpec common = base;
    read_elastic(o, common, directory);
    MaterialSpec spec{.materials = {common}, .zones = {}};
    std::string first;
    for (const std::string key : {"layers", "shapes", "labels", "regions"}) {
        const auto found = o.find(key);
        if (!found) continue;
        if (!first.empty()) found->fail("stands beside `" + first + "`", "use one of layers, shapes, labels, regions");
        first = key;
        if (key == "layers") spec.zones = read_layers(*found, common, directory, spec);
        if (key == "shapes") spec.zones = read_shapes(*found, common, directory, spec);
        if (key == "labels") spec.zones = read_labels(*found, common, directory, spec);
        if (key == "regions") spec.zones = read_regions(*found, common, directory, spec);
    }
    return spec;
}

}  // namespace tetfront
