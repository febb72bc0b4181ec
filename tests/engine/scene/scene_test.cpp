#include "engine/scene/scene.hpp"

#include "engine/base/error.hpp"
#include "tests/support/project.hpp"

#include <fstream>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

const std::string unit_box = R"({"schema_version": 1, "mesh": {"box": {}}})";

Scene parse(const std::string& text, const std::vector<Override>& overrides = {}) {
    return parse_scene(text, "box.json", "/scenes", overrides);
}

/// The scene of `unit_box` with `members` added: with(R"("levels": 3)").
std::string with(const std::string& members) {
    return R"({"schema_version": 1, "mesh": {"box": {}}, )" + members + "}";
}

/// The message for a scene that must be refused; one line.
std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
    try {
        parse(text, overrides);
    } catch (const InputError& error) {
        const std::string message = error.what();
        EXPECT_EQ(message.find_first_of("\n\r\t"), std::string::npos) << message;
        EXPECT_EQ(message.rfind("box.json: ", 0), 0U) << message;
        return message.substr(10);
    }
    ADD_FAILURE() << "accepted: " << text;
    return "";
}

TEST(Scene, WhatIsNotGivenIsTheDefaultOfTheHeader) {
    const Scene scene = parse(unit_box);
    const Scene defaults;
    EXPECT_EQ(scene.name, "box");
    EXPECT_EQ(scene.title, "");
    EXPECT_EQ(scene.file, "box.json");
    EXPECT_EQ(scene.up, 2);
    const auto& box = std::get<BoxMeshSpec>(scene.mesh);
    EXPECT_EQ(box.low, Vec3(0, 0, 0));
    EXPECT_EQ(box.high, Vec3(1, 1, 1));
    EXPECT_EQ(box.cells, (std::array{1, 1, 1}));
    EXPECT_EQ(scene.levels, defaults.levels);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].density), 1000);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].poisson), 0.3);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].young), 1e5);
    EXPECT_EQ(scene.estimation.method, defaults.estimation.method);
    EXPECT_EQ(scene.gravity, defaults.gravity);
    EXPECT_EQ(scene.time_step, defaults.time_step);
    EXPECT_EQ(scene.front.tolerance, defaults.front.tolerance);
    EXPECT_EQ(scene.solver.cg_iterations, defaults.solver.cg_iterations);
    EXPECT_TRUE(scene.view.fitted);
    EXPECT_TRUE(scene.pins.empty());
    EXPECT_TRUE(scene.forces.empty());
}

TEST(Scene, EveryFieldIsRead) {
    const Scene scene = parse(R"({
        "$schema": "../schema/scene.schema.json", "schema_version": 1, "name": "n", "title": "t", "up": "y",
        "mesh": {"surface": {"file": "../models/a.ply", "scale": 0.5, "target_tets": 50}}, "levels": 3,
        "material": {"density": 900, "poisson": 0.4,
                     "young": {"exponential": {"axis": "x", "values": [1e6, 2e4], "at": [-1, 2]}}},
        "estimation": "average",
        "pins": [{"box": {"low": [0, 1, 2], "high": [3, 4, 5]}}, {"half_space": {"point": [1, 2, 3], "normal": [0, 0, 2]}}],
        "gravity": [1, 2, 3],
        "forces": [{"region": {"box": {"low": [0, 0, 0], "high": [1, 1, 1]}}, "force": [4, 5, 6], "start": 0.5, "end": 2}],
        "damping": {"mass": 0.25, "stiffness": 0.125}, "time_step": 0.01,
        "front": {"order": 2, "tolerance": 0.05, "min_level": 1, "max_level": 2},
        "solver": {"scheme": "midpoint", "newton_iterations": 3, "newton_tolerance": 1e-5, "cg_tolerance": 1e-6,
                   "cg_iterations": 77},
        "view": {"eye": [1, 2, 3], "target": [0, 1, 0], "field_of_view": 50, "colouring": "stiffness", "wireframe": true}})");
    EXPECT_EQ(scene.name, "n");
    EXPECT_EQ(scene.title, "t");
    EXPECT_EQ(scene.up, 1);
    const auto& surface = std::get<SurfaceMeshSpec>(scene.mesh);
    EXPECT_EQ(surface.files, (std::vector<std::filesystem::path>{"/models/a.ply"})) << "relative to the scene's directory";
    EXPECT_EQ(surface.scale, 0.5);
    EXPECT_EQ(surface.target_tets, 50);
    EXPECT_EQ(scene.levels, 3);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].density), 900);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].poisson), 0.4);
    const auto& young = std::get<GradientSpec>(scene.material.materials[0].young);
    EXPECT_EQ(young.interpolation, Interpolation::exponential);
    EXPECT_EQ(young.axis, 0);
    EXPECT_EQ(young.values, (std::array{1e6, 2e4}));
    ASSERT_TRUE(young.at);
    EXPECT_EQ(*young.at, (std::array{-1.0, 2.0}));
    EXPECT_EQ(scene.estimation.method, EstimationSpec::Method::average);
    ASSERT_EQ(scene.pins.size(), 2U);
    EXPECT_EQ(std::get<Box>(scene.pins[0]).low, Vec3(0, 1, 2));
    EXPECT_EQ(std::get<Box>(scene.pins[0]).high, Vec3(3, 4, 5));
    EXPECT_EQ(std::get<HalfSpace>(scene.pins[1]).point, Vec3(1, 2, 3));
    EXPECT_EQ(std::get<HalfSpace>(scene.pins[1]).normal, Vec3(0, 0, 2));
    EXPECT_EQ(scene.gravity, Vec3(1, 2, 3));
    ASSERT_EQ(scene.forces.size(), 1U);
    EXPECT_EQ(std::get<Box>(scene.forces[0].region).high, Vec3(1, 1, 1));
    EXPECT_EQ(scene.forces[0].force, Vec3(4, 5, 6));
    EXPECT_EQ(scene.forces[0].start, 0.5);
    EXPECT_EQ(scene.forces[0].end, 2);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].mass_damping), 0.25);
    EXPECT_EQ(std::get<double>(scene.material.materials[0].stiffness_damping), 0.125);
    EXPECT_EQ(scene.time_step, 0.01);
    EXPECT_EQ(scene.front.order, 2);
    EXPECT_EQ(scene.front.tolerance, 0.05);
    EXPECT_EQ(scene.front.min_level, 1);
    EXPECT_EQ(scene.front.max_level, 2);
    EXPECT_EQ(scene.solver.scheme, Scheme::midpoint);
    EXPECT_EQ(scene.solver.newton_iterations, 3);
    EXPECT_EQ(scene.solver.newton_tolerance, 1e-5);
    EXPECT_EQ(scene.solver.cg_tolerance, 1e-6);
    EXPECT_EQ(scene.solver.cg_iterations, 77);
    EXPECT_FALSE(scene.view.fitted);
    EXPECT_EQ(scene.view.eye, Vec3(1, 2, 3));
    EXPECT_EQ(scene.view.target, Vec3(0, 1, 0));
    EXPECT_EQ(scene.view.field_of_view, 50);
    EXPECT_EQ(scene.view.colouring, Colouring::stiffness);
    EXPECT_TRUE(scene.view.wireframe);
}

TEST(Scene, GravityPointsDownUnlessGiven) {
    EXPECT_EQ(parse(with(R"("up": "y")")).gravity, Vec3(0, -9.81, 0));
    EXPECT_EQ(parse(with(R"("up": "x")")).gravity, Vec3(-9.81, 0, 0));
    EXPECT_EQ(parse(with(R"("up": "x", "gravity": [0, 0, 1])")).gravity, Vec3(0, 0, 1));
}

TEST(Scene, GradientWithoutEndsSpansTheMesh) {
    const Scene scene = parse(with(R"("material": {"young": {"linear": {"axis": "z", "values": [1, 2]}}})"));
    const auto& young = std::get<GradientSpec>(scene.material.materials[0].young);
    EXPECT_EQ(young.interpolation, Interpolation::linear);
    EXPECT_FALSE(young.at);
}

TEST(Scene, ASurfaceIsAFileOrAListOfThem) {
    const auto scene = [](const std::string& file) { return R"({"schema_version": 1, "mesh": {"surface": {"file": )" + file + "}}}"; };
    EXPECT_EQ(std::get<SurfaceMeshSpec>(parse(scene(R"(["a.obj", "/b.stl"])")).mesh).files,
              (std::vector<std::filesystem::path>{"/scenes/a.obj", "/b.stl"}));
    EXPECT_EQ(refusal(scene("[]")), "/mesh/surface/file: lists 0 files; use 1 to 100");
    EXPECT_EQ(refusal(scene(R"(["a.obj", 2])")).substr(0, 28), "/mesh/surface/file/1: is 2; ");
}

TEST(Scene, ErrorsSayWhereWhatAndWhatIsAllowed) {
    EXPECT_EQ(refusal(with(R"("material": {"poisson": 0.7})")), "/material/poisson: is 0.7; use a number in [0, 0.5)");
    EXPECT_EQ(refusal(with(R"("material": {"poisson": 0.5})")), "/material/poisson: is 0.5; use a number in [0, 0.5)");
    EXPECT_EQ(refusal(with(R"("material": {"density": 0})")), "/material/density: is 0; use a number in (0, 1e+06]");
    EXPECT_EQ(refusal(with(R"("material": {"densty": 1})")),
              "/material/densty: is not a known key (did you mean \"density\"?); use one of density, poisson, young, "
              "orthotropic, scale, damping, layers, shapes, labels, regions");
    EXPECT_EQ(refusal(with(R"("damping": {"xyzzyx": 1})")),
              "/damping/xyzzyx: is not a known key; use one of mass, stiffness");
    EXPECT_EQ(refusal(with(R"("levels": 2.5)")), "/levels: is 2.5; use an integer in [0, 6]");
    EXPECT_EQ(refusal(with(R"("levels": "2")")), "/levels: is \"2\"; use an integer in [0, 6]");
    EXPECT_EQ(refusal(with(R"("up": "w")")), "/up: is \"w\"; use one of \"x\", \"y\", \"z\"");
    EXPECT_EQ(refusal(with(R"("gravity": [0, 1])")), "/gravity: is [0,1]; use an array of 3 values");
    EXPECT_EQ(refusal(with(R"("gravity": [0, null, 1])")), "/gravity/1: is null; use a number in [-10000, 10000]");
    EXPECT_EQ(refusal(with(R"("pins": [{"half_space": {"point": [0, 0, 0]}}])")),
              "/pins/0/half_space/normal: is missing; it is required");
    EXPECT_EQ(refusal(with(R"("pins": {})")), "/pins: is {}; use an array");
    EXPECT_EQ(refusal(with(R"("view": {"wireframe": 1})")), "/view/wireframe: is 1; use true or false");
    EXPECT_EQ(
        refusal(R"({"schema_version": 1, "mesh": {"box": {}, "surface": {"file": "a"}}})"),
        "/mesh: is {\"box\":{},\"surface\":{\"file\":\"a\"}}; use an object with exactly one of the keys box, surface, tets, "
        "voxels");
    EXPECT_EQ(
        refusal(with(R"("material": {"young": "soft"})")),
        "/material/young: is \"soft\"; use a number in (0, 1e+15], or an object with the key linear, exponential, voxels or per_tet");
}

TEST(Scene, VersionIsRequiredAndCheckedFirst) {
    EXPECT_EQ(refusal(R"({"mesh": {"box": {}}})"), "/schema_version: is missing; it is required");
    EXPECT_EQ(refusal(R"({"schema_version": 2, "new_key": 0})"), "/schema_version: is 2; use 1");
}

TEST(Scene, ValuesThatContradictEachOther) {
    EXPECT_EQ(refusal(R"({"schema_version": 1, "mesh": {"box": {"low": [0, 0, 0], "high": [1, 0, 1]}}})"),
              "/mesh/box/high: is not above `low` along y; use high >= low + 1e-6 m along each axis");
    EXPECT_EQ(refusal(with(R"("front": {"min_level": 3})")).substr(0, 38), "/front/min_level: is 3; use an integer");
    EXPECT_EQ(refusal(with(R"("front": {"min_level": 2, "max_level": 1})")).substr(0, 24), "/front/min_level: is 2; ");
    EXPECT_EQ(refusal(with(R"("levels": 0, "front": {"order": 2})")),
              "/front/order: is 2 but `levels` is 0; use order 1, or levels >= 1");
    EXPECT_EQ(refusal(with(R"("view": {"eye": [0, 0, 0]})")), "/view/target: is missing; it is required");
    EXPECT_NE(refusal(with(R"("view": {"eye": [0, 0, 0], "target": [0, 0, 0]})")), "");
    EXPECT_NE(refusal(with(R"("pins": [{"half_space": {"point": [0, 0, 0], "normal": [0, 0, 0]}}])")), "");
    EXPECT_NE(refusal(with(R"("material": {"young": {"linear": {"axis": "x", "values": [1, 2], "at": [1, 1]}}})")), "");
    EXPECT_NE(refusal(with(R"("forces": [{"region": {"box": {"low": [0, 0, 0], "high": [1, 1, 1]}}, "force": [0, 0, 1],
                            "start": 2, "end": 1}])")),
              "");
}

TEST(Scene, TooManyTetsAreRefusedBeforeMeshing) {
    const std::string big = R"({"schema_version": 1, "levels": 5, "mesh": {"box": {"cells": [8, 8, 2]}}})";
    EXPECT_EQ(refusal(big),
              "/levels: makes 25165824 tets of 768 roots and 5 levels; "
              "use fewer cells or levels: the finest level must have less than 16777216 tets");
    EXPECT_NO_THROW(parse(big, {{"/levels", "4"}}));
    EXPECT_NE(
        refusal(R"({"schema_version": 1, "levels": 3, "mesh": {"surface": {"file": "a", "target_tets": 40000}}})"), "");
}

TEST(Scene, MalformedJsonIsNamedByLineAndColumn) {
    const std::string message = refusal("{\"schema_version\": 1,\n \"mesh\": {\"box\": {},}}");
    EXPECT_EQ(message.substr(0, 35), "line 2, column 21: is not JSON: syn") << message;
    for (const char* text : {"", "{", "nonsense", "{\"a\": NaN}", "{\"a\": Infinity}", "[1, 2", "{\"a\": 1} x",
                             "{\"a\": \"\xff\"}", "// comment\n{}", "{'a': 1}", "{\"a\": 01}"}) {
        EXPECT_NE(refusal(text).find("is not JSON: "), std::string::npos) << text;
    }
    EXPECT_EQ(refusal("[]").substr(0, 10), "/: is []; ");
    EXPECT_EQ(refusal("3").substr(0, 9), "/: is 3; ");
}

TEST(Scene, WhatJsonLibrariesLetThroughIsRefused) {
    EXPECT_EQ(refusal(with(R"("material": {"poisson": 0.1, "poisson": 0.2})")),
              "/material/poisson: appears twice in the same object; keep one of the two");
    EXPECT_EQ(refusal(with(R"("gravity": [0, 1e999, 0])")),
              "/gravity/1: holds a number that is too large; use a number below 1.8e308");
    EXPECT_EQ(refusal(with("\"title\": \"two\\nlines\"")).substr(0, 24), "/title: is \"two\\nlines\";");
    EXPECT_EQ(refusal(with("\"a\\nb/~\": 1")).substr(0, 12), "/a\\nb~1~0: i");
}

TEST(Scene, SizeAndNestingAreLimited) {
    EXPECT_EQ(refusal(std::string((1 << 20) + 1, ' ')), "is larger than 1 MiB; use a smaller scene file");
    for (const std::string open : {"[", "{\"a\":"}) {
        std::string deep;
        while (deep.size() < 1000000) deep += open;
        EXPECT_NE(refusal(deep).find("is nested too deeply; use at most 32 levels"), std::string::npos);
    }
    EXPECT_LT(refusal(with("\"" + std::string(100000, 'k') + "\": 1")).size(), 1000U);
    EXPECT_LT(refusal(with("\"title\": \"" + std::string(100000, 'k') + "\"")).size(), 1000U);
}

TEST(Scene, OverridesReplaceAndAdd) {
    const Scene scene = parse(with(R"("levels": 3, "pins": [{"box": {"low": [0, 0, 0], "high": [1, 1, 1]}}])"),
                              {{"/levels", "1"},
                               {"/front/tolerance", "0.5"},
                               {"/title", "bare words"},
                               {"/up", "y"},
                               {"/pins/0/box/high/2", "7"},
                               {"/mesh", R"({"box": {"cells": [2, 3, 4]}})"}});
    EXPECT_EQ(scene.levels, 1);
    EXPECT_EQ(scene.front.tolerance, 0.5);
    EXPECT_EQ(scene.title, "bare words");
    EXPECT_EQ(scene.up, 1);
    EXPECT_EQ(std::get<Box>(scene.pins[0]).high, Vec3(1, 1, 7));
    EXPECT_EQ(std::get<BoxMeshSpec>(scene.mesh).cells, (std::array{2, 3, 4}));
}

TEST(Scene, ErrorsNameTheOverride) {
    EXPECT_EQ(refusal(unit_box, {{"/levels", "2"}, {"/material/poisson", "0.7"}}),
              "/material/poisson: is 0.7 (override /material/poisson=0.7); use a number in [0, 0.5)");
    EXPECT_EQ(refusal(unit_box, {{"/material/densty", "1"}}),
              "/material/densty: is not a known key (did you mean \"density\"?) (override /material/densty=1); "
              "use one of density, poisson, young, "
              "orthotropic, scale, damping, layers, shapes, labels, regions");
    EXPECT_EQ(refusal(unit_box, {{"/material", R"({"poisson": 1})"}}).substr(0, 37),
              "/material/poisson: is 1 (override /ma");
    EXPECT_EQ(refusal(with("\"levels\": 1"), {{"/levels/x", "1"}}),
              "override /levels/x=1: /levels: is 1 and has no \"x\" in it; override this value as a whole");
    EXPECT_EQ(refusal(with("\"gravity\": [0, 0, 1]"), {{"/gravity/3", "1"}}),
              "override /gravity/3=1: /gravity/3: is not there; use an index from 0 to 2");
    EXPECT_EQ(refusal(unit_box, {{"levels", "1"}}),
              "override levels=1: does not name a value; begin with a JSON pointer such as /front/tolerance");
    EXPECT_NE(refusal(unit_box, {{"", "{}"}}), "");
    EXPECT_NE(refusal(unit_box, {{"/title", "\xff\xfe"}}), "");
    EXPECT_NE(refusal(unit_box, {{"/gravity", "[0, 0, 1e999]"}}), "");
    std::string deep;
    while (deep.size() < 200000) deep += "/a";
    EXPECT_LT(refusal(unit_box, {{deep, "1"}}).size(), 1000U);
}

TEST(Scene, FilesThatCannotBeRead) {
    const auto message = [](const std::filesystem::path& file) -> std::string {
        try {
            load_scene(file);
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(message("/no/such/file.json"),
              "/no/such/file.json: cannot be read: No such file or directory; give the path of a scene file (.json)");
    EXPECT_EQ(message("/"), "/: is a directory; give the path of a scene file (.json)");
    EXPECT_EQ(message("/dev/zero"), "/dev/zero: is larger than 1 MiB; use a smaller scene file");
}

TEST(Scene, RandomDamageNeverDoesAnythingButRefuse) {
    std::ifstream stream(source_folder() / "assets/scenes/bunny.json");
    const std::string original((std::istreambuf_iterator<char>(stream)), {});
    ASSERT_FALSE(original.empty());
    std::mt19937 random(1);
    int refused = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        std::string text = original;
        for (int change = 0; change < 3; ++change) {
            const std::size_t at = random() % text.size();
            switch (random() % 3) {
                case 0:
                    text[at] = static_cast<char>(random() % 256);
                    break;
                case 1:
                    text.erase(at, 1 + random() % 20);
                    break;
                default:
                    text.insert(at, text.substr(random() % text.size(), 10));
            }
        }
        try {
            parse(text);
        } catch (const InputError& error) {
            ++refused;
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    }
    EXPECT_GT(refused, 1500);
}

}  // namespace
}  // namespace tetfront
