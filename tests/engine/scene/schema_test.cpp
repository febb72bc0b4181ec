// assets/schema/scene.schema.json and the parser describe the same format: the shipped scenes satisfy both, both know
// the same keys, and documents with one value changed are refused by both or by none.

#include "engine/base/error.hpp"
#include "engine/scene/scene.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/project.hpp"

#include <filesystem>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {
namespace {

using nlohmann::json;

const std::filesystem::path assets = source_folder() / "assets";

const JsonSchema& schema() {
    static const JsonSchema instance(json::parse(std::ifstream(assets / "schema/scene.schema.json")));
    return instance;
}

/// Two documents that have every key of the format between them.
std::vector<json> full_documents() {
    const char* shared = R"({
        "$schema": "s", "schema_version": 1, "name": "n", "title": "t", "up": "y", "levels": 1,
        "pins": [{"box": {"low": [0, 1, 2], "high": [3, 4, 5]}}, {"half_space": {"point": [1, 2, 3], "normal": [0, 0, 2]}}, {"sphere": {"centre": [0, 0, 0], "radius": 1}}],
        "gravity": [1, 2, 3],
        "forces": [{"region": {"box": {"low": [0, 0, 0], "high": [1, 1, 1]}}, "force": [4, 5, 6], "start": 0.5, "end": 2}],
        "damping": {"mass": 0.25, "stiffness": 0.125}, "time_step": 0.01,
        "front": {"order": 1, "tolerance": 0.05, "min_level": 0, "max_level": 2, "budget": {"tets": 5000, "milliseconds": 10}},
        "solver": {"scheme": "midpoint", "strain": "green", "start": "equilibrium", "newton_iterations": 3, "newton_tolerance": 1e-5, "cg_tolerance": 1e-6,
                   "cg_iterations": 77},
        "ground": {"height": -1, "friction": 0.3},
        "timeline": [{"time": 1, "gravity": [0, 1, 2]}, {"time": 2, "release": 1}],
        "view": {"eye": [1, 2, 3], "target": [0, 1, 0], "field_of_view": 50, "colouring": "stiffness", "range": [1, 2],
                 "surface": false, "wireframe": true, "arrows": false, "legend": false, "background": "dark",
                 "cut": {"point": [0, 0, 0], "normal": [0, 0, 1]},
                 "keyframes": [{"time": 0, "eye": [1, 2, 3], "target": [0, 0, 0]}, {"time": 1, "eye": [2, 2, 3], "target": [0, 0, 0]}]}})";
    json box = json::parse(shared);
    box["mesh"] = json::parse(R"({"box": {"low": [0, 0, 0], "high": [1, 2, 3], "cells": [1, 2, 3]}})");
    box["estimation"] = "average";
    box["material"] = json::parse(R"({"density": 1, "poisson": {"linear": {"axis": "y", "values": [0.25, 0.125], "at": [1, 2]}},
                                      "young": {"linear": {"axis": "x", "values": [1, 2], "at": [0, 1]}},
                                      "shapes": [{"region": {"sphere": {"centre": [0, 0, 0], "radius": 0.5}}, "priority": 1,
                                                  "material": {"poisson": 0.125, "young": {"per_tet": [1, 2]}}}]})");
    json layered = box;
    layered["estimation"] = json::parse(R"({"method": "isolated", "sampled": false, "alphas": [0.01, 0.1],
                                            "relative_tolerance": 0.25, "stress_tolerance": 0.125})");
    layered["material"] = json::parse(R"({"layers": {"axis": "z", "boundaries": [0.5, 0.75], "materials": [{"young": 2},
        {"density": {"voxels": {"file": "a.nrrd", "scale": 0.5, "factor": 2, "sampling": "nearest"}},
         "scale": {"exponential": {"axis": "z", "values": [1, 2], "at": [0, 1]}},
         "damping": {"mass": {"linear": {"axis": "x", "values": [0, 1], "at": [0, 1]}}, "stiffness": {"per_tet": [0.5]}},
         "orthotropic": {"young": [4, 2, 2], "poisson": [0.25, 0.25, 0.25], "shear": [1, 1, 1], "axes": [[1, 1, 0], [0, 0, 1]]}}, {}]}})");
    json labelled = box;
    labelled["mesh"] = json::parse(R"({"voxels": {"file": "b.inr.gz", "scale": 0.25, "labels": [1, 2], "surface_cell": 0.5, "target_tets": 50}})");
    labelled["material"] = json::parse(R"({"orthotropic": {"young": [4, 2, 2], "poisson": [0.25, 0.25, 0.25], "shear": [1, 1, 1]},
        "scale": {"per_tet": [2]}, "density": {"linear": {"axis": "x", "values": [1, 2], "at": [0, 1]}},
        "damping": {"mass": {"exponential": {"axis": "x", "values": [1, 2], "at": [0, 1]}}, "stiffness": {"voxels": {"file": "a.nrrd"}}},
        "labels": {"file": "b.inr.gz", "scale": 0.25, "otherwise": {"density": 2},
                   "materials": [{"labels": [1, 2], "material": {"scale": {"linear": {"axis": "x", "values": [1, 2], "at": [0, 1]}}}},
                                 {"labels": [0], "material": {"scale": {"voxels": {"file": "c.nrrd"}}}}]}})");
    json imported = box;
    imported["mesh"] = json::parse(R"({"tets": {"file": "a.msh", "scale": 0.5}})");
    imported["material"] = json::parse(R"({"regions": {"otherwise": {"poisson": {"per_tet": [0.25]}, "density": {"per_tet": [1, 2]}},
                   "materials": [{"regions": [1, 2], "material": {"density": {"exponential": {"axis": "x", "values": [1, 2], "at": [0, 1]}}}},
                                 {"regions": [3], "material": {"young": {"voxels": {"file": "c.nrrd"}}, "poisson": {"voxels": {"file": "c.nrrd"}}}},
                                 {"regions": [4], "material": {"poisson": {"exponential": {"axis": "x", "values": [0.1, 0.2], "at": [0, 1]}}}}]}})");
    json surface = json::parse(shared);
    surface["mesh"] = json::parse(R"({"surface": {"file": "a.ply", "scale": 0.5, "target_tets": 100}})");
    surface["material"] = json::parse(R"({"young": {"exponential": {"axis": "x", "values": [1, 2], "at": [0, 1]}}})");
    return {box, layered, labelled, imported, surface};
}

std::string parser_error(const json& document) {
    try {
        parse_scene(document.dump(), "x", "/", {});
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// Rules that relate two values, which the schema states in its description only.
bool is_relation(const std::string& message) {
    for (const char* part : {"is not above `low`", "is not ascending", "is not after `start`", "is where `target` is",
                             "has no direction", "is not after the keyframe before", "but there are", "but `levels` is 0", "stands beside `",
                             "has nothing to scale", "has a material already", " layers for ", "is not above the one before it",
                             "is not positive definite", "has no two directions", "for an exponential gradient", "is empty; give", "makes ", "/front/min_level: is"}) {
        if (message.find(part) != std::string::npos) return true;
    }
    return false;
}

/// Visits every value of the document with its pointer.
template <class Visit>
void walk(const json& node, const std::string& pointer, const Visit& visit) {
    visit(node, pointer);
    if (!node.is_structured()) return;
    for (const auto& [key, child] : node.items()) walk(child, pointer + '/' + key, visit);
}

TEST(SceneSchema, ShippedScenesSatisfySchemaAndParser) {
    int scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(assets / "scenes")) {
        if (entry.path().extension() != ".json") continue;
        ++scenes;
        EXPECT_EQ(schema().error(json::parse(std::ifstream(entry.path()))), "") << entry.path();
        EXPECT_NO_THROW(load_scene(entry.path())) << entry.path();
    }
    EXPECT_GE(scenes, 3);
}

TEST(SceneSchema, FullDocumentsUseEveryPropertyOfTheSchema) {
    std::set<const json*> used;  // property tables that a document completes
    std::set<const json*> all;
    std::map<const json*, std::set<std::string>> keys;
    const auto follow = [&](const auto& self, const json& unresolved, const json& value) -> void {
        const json& node = schema().resolve(unresolved);
        if (node.contains("oneOf")) {
            for (const json& option : node["oneOf"]) {
                if (schema().resolve(option).value("type", "") == (value.is_object() ? "object" : "number"))
                    self(self, option, value);
            }
        }
        if (node.contains("properties") && value.is_object()) {
            for (const auto& [key, child] : value.items()) {
                keys[&node["properties"]].insert(key);
                self(self, node["properties"].at(key), child);
            }
        }
        if (node.contains("items") && value.is_array()) {
            for (const json& element : value) self(self, node["items"], element);
        }
    };
    for (const json& document : full_documents()) {
        EXPECT_EQ(schema().error(document), "");
        EXPECT_EQ(parser_error(document), "");
        follow(follow, schema().root(), document);
    }
    int tables = 0;
    walk(schema().root(), "", [&](const json& node, const std::string& pointer) {
        if (!node.is_object() || !node.contains("properties") || !node["properties"].is_object()) return;
        ++tables;
        for (const auto& [key, ignored] : node["properties"].items()) {
            EXPECT_TRUE(keys[&node["properties"]].contains(key))
                << pointer << " has " << key << ", which no test document uses";
        }
    });
    EXPECT_GE(tables, 12);
}

TEST(SceneSchema, BothKnowTheSameKeys) {
    for (const json& document : full_documents()) {
        walk(document, "", [&](const json& node, const std::string& pointer) {
            if (!node.is_object()) return;
            // The parser lists what it knows: "... is not a known key; use one of a, b, c". Each must be known to the
            // schema and, with the test above, the other way round.
            json changed = document;
            changed[json::json_pointer(pointer)]["@"] = 1;
            EXPECT_NE(schema().error(changed), "") << pointer;
            const std::string message = parser_error(changed);
            const std::size_t list = message.find("use one of ");
            ASSERT_NE(list, std::string::npos) << pointer << ": " << message;
            std::istringstream words(message.substr(list + 11));
            for (std::string key; words >> key;) {
                if (key.back() == ',') key.pop_back();
                json with_key = document;
                with_key[json::json_pointer(pointer)][key] = nullptr;
                EXPECT_EQ(schema().error(with_key).find("additionalProperties"), std::string::npos)
                    << pointer << '/' << key;
            }
        });
    }
}

TEST(SceneSchema, OneChangedValueIsRefusedByBothOrByNone) {
    const json values =
        json::parse(R"([null, true, -1, 0, 1, 2.0, 0.25, 2.5, 6, 7, 99, 100, 300, 5e3, 2e5, 2e6, 1e12, 1e30, -1e30,
                                        "", "x", "level", "midpoint", "a\nb", [], {}, [1, 2], [0, 0, 0], [1, 1, 1], [1, 2, 3, 4],
                                        {"box": {}}, {"x": 1}, [[]], [{}]])");
    int accepted = 0;
    int refused = 0;
    int relations = 0;
    const auto compare = [&](const json& document, const std::string& what) {
        const std::string by_schema = schema().error(document);
        const std::string by_parser = parser_error(document);
        if (by_schema.empty() && is_relation(by_parser)) {
            ++relations;
            return;
        }
        EXPECT_EQ(by_schema.empty(), by_parser.empty())
            << what << "\nschema: " << by_schema << "\nparser: " << by_parser << "\n"
            << document;
        ++(by_parser.empty() ? accepted : refused);
    };
    for (const json& document : full_documents()) {
        walk(document, "", [&](const json& node, const std::string& pointer) {
            for (const json& value : values) {
                json changed = document;
                changed[json::json_pointer(pointer)] = value;
                compare(changed, pointer + " = " + value.dump());
            }
            if (node.is_object()) {
                for (const auto& [key, ignored] : node.items()) {
                    json changed = document;
                    changed[json::json_pointer(pointer)].erase(key);
                    compare(changed, "without " + pointer + '/' + key);
                }
            }
            if (node.is_string()) {
                for (int length : {100, 101, 300, 301, 4096, 4097}) {
                    std::string text;
                    for (int i = 0; i < length; ++i) text += "\u00e9";  // two bytes, one character
                    json changed = document;
                    changed[json::json_pointer(pointer)] = text;
                    compare(changed, pointer + " = " + std::to_string(length) + " characters");
                }
            }
        });
    }
    EXPECT_GT(accepted, 300);
    EXPECT_GT(refused, 2000);
    EXPECT_LT(relations, accepted / 2);
}

}  // namespace
}  // namespace tetfront
