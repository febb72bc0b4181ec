#pragma once
// Reads what a scene says about its material, and the regions and axes that other parts of a scene are made of, too.
//
//     if (auto material = scene.find("material")) spec = read_material(*material, base, directory);

#include "engine/base/region.hpp"
#include "engine/scene/json_reader.hpp"
#include "engine/scene/material_spec.hpp"

#include <filesystem>

namespace tetfront {

/// [m] coordinates of scenes.
inline constexpr Range coordinate_range = within(-largest_coordinate, largest_coordinate);

/// The scene's `material`. base: what is not said. Relative paths are relative to `directory`. Throws InputError.
MaterialSpec read_material(const JsonValue& value, const ElasticSpec& base, const std::filesystem::path& directory);
/// {"mass": ..., "stiffness": ...}, each a scalar function of position.
void read_damping(const JsonValue& value, ElasticSpec& material, const std::filesystem::path& directory);
/// {"box": ...}, {"half_space": ...} or {"sphere": ...}.
Region read_region(const JsonValue& value);
/// Throws InputError unless high - low >= 1e-6 m along each axis.
void check_corners(const JsonObject& box, const Vec3& low, const Vec3& high);
/// An axis by its letter.
int read_axis(const JsonValue& value);

}  // namespace tetfront
