// From the scene's `material` to what the simulation is made of.
#include "engine/simulation/scene_material.hpp"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/simulation/simulation.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tetfront {
namespace {

class SceneMaterial : public ::testing::Test {
 protected:
    /// Two cubes along x, 0..2 x 0..1 x 0..1: roots 0..5 in the first.
    [[nodiscard]] Scene scene(const std::string& material, const std::string& more = "") const {
        return parse_scene(R"({"schema_version": 1, "levels": 1, "mesh": {"box": {"high": [2, 1, 1], "cells": [2, 1, 1]}},
                               "material": )" + material + (more.empty() ? "" : ", " + more) + "}",
                           "scene.json", directory_.path());
    }
    [[nodiscard]] static Material at(const Scene& s, const Vec3& x, int root = 0) {
        const auto& box = std::get<BoxMeshSpec>(s.mesh);
        return make_stiffness(s, box_mesh(box.low, box.high, box.cells)).at(x, TetId(root));
    }
    [[nodiscard]] static double young(const Scene& s, const Vec3& x, int root = 0) {
        return representative_young(at(s, x, root).elasticity);
    }
    [[nodiscard]] static std::string refusal(const Scene& s) {
        try {
            build_model(s);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    /// 2 x 1 x 1 voxels of edge 1 whose corners fill the box.
    void write_image(const std::string& name, const std::vector<float>& values) const {
        std::string bytes = "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\nencoding: raw\nendian: little\n"
                            "space dimension: 3\nspace directions: (1000,0,0) (0,1000,0) (0,0,1000)\n"
                            "space origin: (500,500,500)\n\n";
        const std::size_t header = bytes.size();
        bytes.resize(header + 4 * values.size());
        std::memcpy(bytes.data() + header, values.data(), 4 * values.size());
        directory_.write(name, bytes);
    }
    TemporaryFolder directory_;
};

TEST_F(SceneMaterial, GradientSpansTheMeshOrItsEnds) {
    const Scene whole = scene(R"({"young": {"linear": {"axis": "x", "values": [1e4, 3e4]}}})");
    EXPECT_NEAR(young(whole, {0.5, 0, 0}), 1.5e4, 1e-6);
    const Scene ends = scene(R"({"young": {"exponential": {"axis": "x", "values": [1e4, 1e6], "at": [0, 1]}}})");
    EXPECT_NEAR(young(ends, {0.5, 0, 0}), 1e5, 1e-6);
    EXPECT_NEAR(young(ends, {1.5, 0, 0}), 1e6, 1e-6);
}

TEST_F(SceneMaterial, LayersDifferFromWhatTheyHaveInCommon) {
    const Scene s = scene(R"({"density": 900, "young": 1e4, "layers": {"axis": "x", "boundaries": [0.5, 1.5],
                              "materials": [{}, {"young": 1e6, "density": 1200}, {"young": 2e4}]}})");
    EXPECT_NEAR(young(s, {0.4, 0, 0}), 1e4, 1e-6);
    EXPECT_NEAR(young(s, {0.6, 0, 0}), 1e6, 1e-4);
    EXPECT_NEAR(young(s, {1.6, 0, 0}), 2e4, 1e-6);
    EXPECT_EQ(at(s, {0.4, 0, 0}).density, 900);
    EXPECT_EQ(at(s, {0.6, 0, 0}).density, 1200);
}

TEST_F(SceneMaterial, ShapesLieInTheCommonMaterialByPriority) {
    const Scene s = scene(R"({"young": 1e4, "shapes": [
        {"region": {"sphere": {"centre": [0.5, 0.5, 0.5], "radius": 0.25}}, "priority": 1, "material": {"young": 1e6}},
        {"region": {"half_space": {"point": [1, 0, 0], "normal": [1, 0, 0]}}, "material": {"young": 1e5}}]})");
    EXPECT_NEAR(young(s, {0.5, 0.5, 0.5}), 1e6, 1e-4);
    EXPECT_NEAR(young(s, {0.9, 0.5, 0.5}), 1e5, 1e-5);
    EXPECT_NEAR(young(s, {1.5, 0.5, 0.5}), 1e4, 1e-6);
}

TEST_F(SceneMaterial, VoxelsGiveValuesAndLabels) {
    write_image("e.nrrd", {10, 20});
    const Scene values = scene(R"({"young": {"voxels": {"file": "e.nrrd", "scale": 0.001, "factor": 1000}}})");
    EXPECT_NEAR(young(values, {0.5, 0.5, 0.5}), 1e4, 1e-6);
    EXPECT_NEAR(young(values, {1, 0.5, 0.5}), 1.5e4, 1e-6);
    write_image("labels.nrrd", {1, 7});
    const Scene labels = scene(R"({"labels": {"file": "labels.nrrd", "scale": 0.001,
        "materials": [{"labels": [1], "material": {"young": 1e4}}], "otherwise": {"young": 1e6}}})");
    EXPECT_NEAR(young(labels, {0.5, 0.5, 0.5}), 1e4, 1e-6);
    EXPECT_NEAR(young(labels, {1.5, 0.5, 0.5}), 1e6, 1e-4);
    EXPECT_EQ(build_model(values)->mass, build_model(labels)->mass);
}

TEST_F(SceneMaterial, TroubleIsNamedByFileAndPlace) {
    write_image("hole.nrrd", {1, 0});
    const std::string unknown = refusal(scene(R"({"labels": {"file": "hole.nrrd", "scale": 0.001,
        "materials": [{"labels": [1], "material": {}}]}})"));
    EXPECT_NE(unknown.find("hole.nrrd: voxel (1, 0, 0)"), std::string::npos) << unknown;
    EXPECT_NE(unknown.find("otherwise"), std::string::npos) << unknown;
    write_image("nan.nrrd", {1, NAN});
    EXPECT_NE(refusal(scene(R"({"young": {"voxels": {"file": "nan.nrrd", "scale": 0.001}}})")).find("voxel (1, 0, 0)"),
              std::string::npos);
    write_image("negative.nrrd", {1, -1});
    const std::string negative = refusal(scene(R"({"young": {"voxels": {"file": "negative.nrrd", "scale": 0.001}}})"));
    EXPECT_NE(negative.find("negative.nrrd: voxel (1, 0, 0): is -1"), std::string::npos) << negative;
    write_image("zero.nrrd", {1, 0});
    const std::string zero = refusal(scene(R"({"young": {"voxels": {"file": "zero.nrrd", "scale": 0.001, "sampling": "nearest"}}})"));
    EXPECT_NE(zero.find("scene.json: /material: Young's modulus at ("), std::string::npos) << zero;
    EXPECT_NE(zero.find("zero.nrrd, voxel (1, 0, 0)"), std::string::npos) << zero;
    EXPECT_NE(refusal(scene(R"({"layers": {"axis": "x", "boundaries": [1], "materials": [{}, {"young": {"per_tet": [1]}}]}})"))
                  .find("scene.json: /material/layers/materials/1/young/per_tet: has 1 values"),
              std::string::npos);
    EXPECT_NE(refusal(scene(R"({"young": {"voxels": {"file": ".", "scale": 0.001}}})")).find("is no regular file"),
              std::string::npos);
    EXPECT_NE(refusal(scene(R"({"labels": {"file": "none.nrrd", "materials": [{"labels": [1], "material": {}}]}})"))
                  .find("none.nrrd: cannot be opened"),
              std::string::npos);
    EXPECT_NE(refusal(scene(R"({"young": {"per_tet": [1, 2]}})")).find("/material/young/per_tet: has 2 values; the coarsest level has 12 tets"),
              std::string::npos);
    EXPECT_NE(refusal(scene(R"({"regions": {"materials": [{"regions": [4], "material": {}}]}})")).find("region 0 of tet 0"),
              std::string::npos);
}

/// An image that just covers the object covers its surface, too.
TEST_F(SceneMaterial, LabelsMayEndWhereTheObjectDoes) {
    write_image("all.nrrd", {1, 2});
    const auto model = build_model(scene(R"({"labels": {"file": "all.nrrd", "scale": 0.001,
        "materials": [{"labels": [1], "material": {"young": 1e4}}, {"labels": [2], "material": {"young": 1e6}}]}})"));
    EXPECT_NEAR(model->frame_model->young_range[0], 1e4F, 1);
    EXPECT_NEAR(model->frame_model->young_range[1], 1e6F, 1);
}

/// Tets that only touch a boundary must not differ by a rounding error: that would sample and bracket them.
TEST_F(SceneMaterial, BoundariesBetweenTetsLeaveEachSideUniform) {
    // Whether four quarters sum up to the bit depends on the number: several.
    for (const std::string first : {"1e5", "1.1e5", "1.3e5", "1.7e5", "1.9e5"}) {
        const std::string second = first == "1.1e5" ? "{}" : R"({"young": 1.23e6})";
        const auto model = build_model(scene(R"({"young": )" + first + R"(, "layers": {"axis": "x", "boundaries": [1],
                                                 "materials": [{}, )" + second + "]}}"));
        EXPECT_LE(model->matrices.elasticity.values().size(), 2U);
        EXPECT_TRUE(model->matrices.valid_range.empty());
        EXPECT_TRUE(model->matrices.bracket.empty());
    }
}

TEST_F(SceneMaterial, EachTetOfTheCoarsestLevelHasItsValue) {
    const Scene s = scene(R"({"young": {"per_tet": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]}})");
    EXPECT_NEAR(young(s, {0, 0, 0}, 4), 5, 1e-12);
    const auto model = build_model(s);
    for (const TetId t : model->tree.level(0))
        EXPECT_NEAR(representative_young(model->matrices.elasticity[t]), 1 + static_cast<double>(t.index()), 1e-9);
}

TEST_F(SceneMaterial, RegionsOfAnImportedMesh) {
    directory_.write("two.mesh",
                     "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n"
                     "Tetrahedra\n2\n1 2 3 4 1\n2 3 4 5 2\nEnd\n");
    const Scene s = parse_scene(R"({"schema_version": 1, "levels": 1, "mesh": {"tets": {"file": "two.mesh", "scale": 0.5}},
        "material": {"regions": {"materials": [{"regions": [1], "material": {"density": 1}},
                                               {"regions": [2], "material": {"density": 3}}]}}})",
                                "scene.json", directory_.path());
    const auto model = build_model(s);
    ASSERT_EQ(model->tree.tet_count(0), 2U);
    EXPECT_NEAR(model->mass, (1.0 / 6 * 1 + 1.0 / 3 * 3) / 8, 1e-12);
    EXPECT_GT(model->surface.mesh.triangles.size(), 0U);
    Simulation simulation(model);
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(simulation.step().converged);
}

TEST_F(SceneMaterial, SamplesGiveValidRangesUnlessTurnedOff) {
    const std::string material = R"({"young": {"exponential": {"axis": "x", "values": [1e4, 1e6]}}})";
    EXPECT_FALSE(build_model(scene(material))->matrices.valid_range.empty());
    EXPECT_TRUE(build_model(scene(material, R"("estimation": {"sampled": false})"))->matrices.valid_range.empty());
    const double coarse = build_model(scene(material))->matrices.elasticity[TetId(0)](0, 0);
    const double bound = build_model(scene(material, R"("estimation": "average")"))->matrices.elasticity[TetId(0)](0, 0);
    const double isolated = build_model(scene(material, R"("estimation": "isolated")"))->matrices.elasticity[TetId(0)](0, 0);
    EXPECT_LT(coarse, bound);
    EXPECT_LT(isolated, coarse);
}

TEST_F(SceneMaterial, SecondStartTakesTheMatricesFromTheCache) {
    const Scene s = scene(R"({"young": {"exponential": {"axis": "x", "values": [1e4, 1e6]}}})");
    std::string warnings;
    const CacheSettings cache{.directory = directory_.path() / "cache", .warn = [&](const std::string& w) { warnings += w; }};
    const auto first = build_model(s, {}, cache), second = build_model(s, {}, cache);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cache.directory), {}), 1);
    EXPECT_EQ(first->matrices.elasticity, second->matrices.elasticity);
    EXPECT_EQ(first->density, second->density);
    EXPECT_EQ(warnings, "");
}

TEST_F(SceneMaterial, DampingOfTheSceneIsTheDefaultOfItsMaterials) {
    const Scene s = scene(R"({"layers": {"axis": "x", "boundaries": [1], "materials": [{}, {"damping": {"mass": 2}}]}})",
                          R"("damping": {"mass": 0.5, "stiffness": 0.25})");
    EXPECT_EQ(at(s, {0.5, 0, 0}).mass_damping, 0.5);
    EXPECT_EQ(at(s, {1.5, 0, 0}).mass_damping, 2);
    EXPECT_EQ(at(s, {1.5, 0, 0}).stiffness_damping, 0.25);
    const auto model = build_model(s);
    EXPECT_EQ(model->matrices.mass_damping[TetId(0)], 0.5);
    EXPECT_EQ(model->matrices.mass_damping[TetId(11)], 2);
}

/// Backward Euler on a body that only drifts: v falls by 1 / (1 + h a) a step, whatever its stiffness.
TEST_F(SceneMaterial, MassDampingSlowsADriftingBody) {
    Scene s = scene(R"({"young": 1e5, "damping": {"mass": 3}})", R"("gravity": [0, 0, -1])");
    s.solver.newton_iterations = 20;
    s.solver.newton_tolerance = 1e-12;
    s.solver.cg_tolerance = 1e-12;
    const auto model = build_model(s);
    Simulation simulation(model);
    double v = 0;
    for (int i = 0; i < 30; ++i) {
        simulation.step();
        v = (v - s.time_step) / (1 + 3 * s.time_step);
    }
    EXPECT_NEAR(simulation.momentum().linear.z(), model->mass * v, 1e-8 * model->mass);
}

}  // namespace
}  // namespace tetfront
