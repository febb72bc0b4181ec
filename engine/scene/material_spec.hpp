#pragma once
// What a scene says about its material, as plain data: constants that may vary with rest position, and which material is
// where. simulation/scene_material.hpp makes a stiffness function of it.
//
//     MaterialSpec jelly;                                            // E 1e5 Pa, nu 0.3, 1000 kg/m^3 everywhere
//     MaterialSpec core{.materials = {soft, stiff}, .zones = ShapesSpec{{{Sphere{{0, 0, 0}, 0.1}, 1, 0}}}};

#include "engine/material/material.hpp"
#include "engine/material/scalar_function.hpp"
#include "engine/material/zones.hpp"

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tetfront {

/// From one value to another along an axis.
struct GradientSpec {
    int axis = 0;                             // 0 x, 1 y, 2 z
    std::optional<std::array<double, 2>> at;  // [m] coordinates of both ends; absent: the mesh's extent
    std::array<double, 2> values{};           // at both ends
    Interpolation interpolation = Interpolation::linear;
};
/// Measured values.
struct VoxelsSpec {
    std::filesystem::path file;  // absolute; see read_voxel_image
    double scale = 1;            // metres in a unit of the file
    double factor = 1;           // of the constant in a unit of the file
    VoxelSampling sampling = VoxelSampling::linear;
};
/// One value for each tet of the coarsest level.
struct PerTetSpec {
    std::vector<double> values;
    std::string pointer;  // where it stands in the scene
};
using ScalarSpec = std::variant<double, GradientSpec, VoxelsSpec, PerTetSpec>;

struct ElasticSpec {
    ScalarSpec density = 1000.0;           // [kg/m^3] > 0
    ScalarSpec young = 1e5;                // [Pa] > 0
    ScalarSpec poisson = 0.3;              // [0, 0.5)
    std::optional<Orthotropic> orthotropic;  // instead of young and poisson
    ScalarSpec scale = 1.0;                // > 0, of the orthotropic constants
    ScalarSpec mass_damping = 0.0;         // [1/s] Rayleigh, >= 0
    ScalarSpec stiffness_damping = 0.0;    // [s] Rayleigh, >= 0
};

/// materials[i] between boundaries[i - 1] and boundaries[i].
struct LayersSpec {
    int axis = 0;
    std::vector<double> boundaries;  // [m] ascending
};
/// materials[0] outside of all shapes.
struct ShapesSpec {
    std::vector<ZoneShape> shapes;  // zone: index into materials
};
/// Labels of a voxel image.
struct LabelsSpec {
    std::filesystem::path file;  // absolute
    double scale = 1;            // metres in a unit of the file
    std::map<long long, int> zone_of_label;
    std::optional<int> otherwise;  // zone of other labels, and outside of the image; absent: an error
};
/// Regions of an imported tet mesh.
struct RegionsSpec {
    std::map<int, int> zone_of_region;
    std::optional<int> otherwise;
};

struct MaterialSpec {
    std::vector<ElasticSpec> materials = {ElasticSpec{}};  // >= 1
    std::variant<std::monostate, LayersSpec, ShapesSpec, LabelsSpec, RegionsSpec> zones;  // monostate: materials[0] everywhere
};

/// [m] of coordinates of scenes.
inline constexpr double largest_coordinate = 1e6;

}  // namespace tetfront
