#pragma once
// A scene: what to simulate, as plain data. Read from JSON; every error names the file and the JSON pointer.
//
//     Scene scene = load_scene("assets/scenes/bunny.json", {{"/front/tolerance", "0.01"}});
//
// SI units; the scene's axes are its mesh's. Defaults below are the format's defaults. The JSON form of every field is
// assets/schema/scene.schema.json. Relative paths are relative to the scene file.

#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/base/region.hpp"
#include "engine/base/types.hpp"
#include "engine/base/strain_measure.hpp"
#include "engine/scene/material_spec.hpp"
#include "engine/scene/override.hpp"
#include "engine/scene/view_spec.hpp"

namespace tetfront {

/// Tets of the finest level must be fewer.
inline constexpr double max_leaves = 1 << 24;

struct BoxMeshSpec {
    Vec3 low = {0, 0, 0}, high = {1, 1, 1};  // [m]
    std::array<int, 3> cells = {1, 1, 1};    // each in 1..256
};
struct SurfaceMeshSpec {
    std::vector<std::filesystem::path> files;  // absolute after loading; one or more, in the same axes and units
    double scale = 1;                          // file units -> metres
    int target_tets = 1000;                    // roots to aim for in all, 10..200000
};
/// Tets from a file; see read_tet_mesh.
struct TetMeshSpec {
    std::filesystem::path file;     // absolute after loading
    double scale = 1;               // file units -> metres
};
/// What lies inside of the boundary of some labels of a voxel image.
struct VoxelMeshSpec {
    std::filesystem::path file;     // absolute after loading; see read_voxel_image
    double scale = 1;               // file units -> metres
    std::set<long long> labels;     // empty: all but 0
    double surface_cell = 0;        // [m] resolution of the surface; 0: 1/100 of the longest side
    int target_tets = 1000;         // as for a surface
};
using MeshSpec = std::variant<BoxMeshSpec, SurfaceMeshSpec, TetMeshSpec, VoxelMeshSpec>;

/// A constant force spread evenly over the surface vertices in a region.
struct ForceSpec {
    Region region;
    Vec3 force;                // [N] total
    double start = 0;          // [s]
    double end = std::numeric_limits<double>::infinity();
};

/// A half-space that pushes out what sinks into it, below `height` along the scene's `up`; see simulation/ground.hpp.
struct GroundSpec {
    double height = 0;      // [m]
    double friction = 0.5;  // Coulomb's coefficient, 0..10
};

/// How coarse tets get their elasticity matrices ([Imai] section 4); see mechanics/elasticity.hpp.
struct EstimationSpec {
    enum class Method { average, mean_strain, isolated, uniform_stress } method = Method::mean_strain;
    /// Nonlinear samples and valid strain ranges; otherwise the tangent at rest, valid everywhere.
    bool sampled = true;
    std::vector<double> alphas = {0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32};  // ascending, in (0, 0.49)
    double relative_tolerance = 1e-2;  // T1 of [Imai] (4)
    double stress_tolerance = 1e-4;    // T2 of (5), relative to sqrt(C_jj C_mm)
};
enum class Scheme { backward_euler, midpoint, bdf2, explicit_euler, automatic };
enum class Start { rest_shape, equilibrium };

struct FrontSpec {
    int order = 2;             // 1: linear tets, 2: quadratic tets on the tree's own vertices; without levels 1
    double tolerance = 0.02;   // target of the relative displacement error estimate, > 0
    int budget_tets = 1 << 28;        // the front never has more active tets, >= 1
    double budget_milliseconds = 0;   // aimed at per step; 0: no limit. Makes runs depend on the machine's speed
    int min_level = 0;         // never coarser
    int max_level = 99;        // never finer; clamped to the tree (order 2: one level above the leaves)

    /// The deepest level that can be active in a tree of this depth.
    [[nodiscard]] int finest(int depth) const;
};

struct SolverSpec {
    Scheme scheme = Scheme::backward_euler;  // automatic: backward Euler or explicit, see mechanics/time_stepper.hpp
    Start start = Start::rest_shape;         // equilibrium: hanging still under its loads; needs pins
    StrainMeasure strain = StrainMeasure::corotated;
    int newton_iterations = 1;  // linearised steps at most per time step, 1..50
    double newton_tolerance = 1e-4;  // of the residual, relative to the largest force scale
    double cg_tolerance = 1e-4;      // relative residual
    int cg_iterations = 2000;        // at most; the StepReport says when it was not enough
};

/// What changes at a moment; forces have times of their own.
struct TimelineEvent {
    double time = 0;              // [s] >= 0; takes place before the time step that starts nearest to it
    std::optional<Vec3> gravity;  // [m/s^2] from now on
    std::optional<int> release;   // number of an entry of `pins` that holds nothing from now on
};

struct Scene {
    std::string name;                  // default: file name without extension
    std::string title;                 // one line for people
    std::filesystem::path file;        // where it came from
    int up = 2;                        // axis: 0 x, 1 y, 2 z
    MeshSpec mesh;
    int levels = 2;                    // subdivisions below the roots, 0..6
    MaterialSpec material;
    EstimationSpec estimation;
    std::vector<Region> pins;          // tree vertices inside do not move
    Vec3 gravity = {0, 0, -9.81};      // [m/s^2] default: 9.81 against `up`
    std::vector<ForceSpec> forces;
    std::vector<TimelineEvent> timeline;
    std::optional<GroundSpec> ground;  // none: nothing touches anything
    double time_step = 1.0 / 60;       // [s] 1e-6..1
    FrontSpec front;
    SolverSpec solver;
    ViewSpec view;
};

/// Reads a scene file. Throws InputError{file, JSON pointer, problem, what is allowed} for a file that cannot be read,
/// malformed JSON (line and column), unknown keys, wrong types, values out of range; and for an override that does so.
Scene load_scene(const std::filesystem::path& file, const std::vector<Override>& overrides = {});
/// The same from text; relative paths are relative to `directory`, errors name `source`.
Scene parse_scene(std::string_view text, const std::string& source, const std::filesystem::path& directory,
                  const std::vector<Override>& overrides = {});

}  // namespace tetfront
