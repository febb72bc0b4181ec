#pragma once
// The simulation: owns the front and the state, and steps them. One thread owns it; others see Frames.
//
//     auto model = build_model(load_scene("assets/scenes/bunny.json"), progress);
//     Simulation simulation(model);
//     for (int i = 0; i < 600; ++i) {
//         StepReport report = simulation.step();
//         if (!report.converged) ...
//     }
//     std::shared_ptr<const Frame> frame = simulation.frame();

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/progress.hpp"
#include "engine/base/types.hpp"
#include "engine/mechanics/elasticity_cache.hpp"
#include "engine/mechanics/momentum.hpp"
#include "engine/scene/scene.hpp"
#include "engine/simulation/edits.hpp"
#include "engine/simulation/frame.hpp"
#include "engine/simulation/ground.hpp"
#include "engine/tree/front.hpp"
#include "engine/tree/surface.hpp"
#include "engine/tree/tet_tree.hpp"

namespace tetfront {

/// A constant force at a point of the surface, between two times.
struct AttachedForce {
    Attachment at;
    Vec3 force;                          // [N]
    double start = 0, end = 0;           // [s]
    std::size_t spec = 0;                // index into the scene's forces
};

/// Everything that never changes while simulating; may be shared by any number of simulations.
struct Model {
    Scene scene;
    TetTree tree;
    ElasticityMatrices matrices;
    PerTet<double> density;              // [T] mass-weighted means [kg/m^3]
    Surface surface;
    PerVertex<std::uint8_t> pinned;      // [V] nonzero: does not move
    PerTet<std::uint8_t> unresolved;     // [T] nonzero: never active, it misses a pinned region that its descendants have
    std::vector<AttachedForce> forces;
    std::optional<Ground> ground;
    std::shared_ptr<const FrameModel> frame_model;
    double mass = 0;                     // [kg]
    double size = 0;                     // [m] longest edge of the rest box, the unit of [Imai]'s errors
    bool has_pins = false;
    bool held = false;                   // the pins leave no rigid motion: all energy of motion turns into deformation
};

/// cache: where elasticity matrices are kept for the next time. Throws InputError when a file that the scene names cannot
/// be read, the mesh cannot be made, or the material is out of range somewhere.
std::shared_ptr<const Model> build_model(Scene scene, const Progress& progress = {}, const CacheSettings& cache = {});

/// What one step did. Numerical trouble is data here; a step never throws for it and never leaves a NaN.
struct StepReport {
    std::uint64_t step = 0;
    double time = 0;                             // [s] after the step
    bool converged = true;                       // solver reached its tolerance
    int newton_iterations = 0;
    int solver_iterations = 0;                   // CG, summed
    int substeps = 0;                            // explicit ones; 0: the step was implicit
    double residual = 0;                         // relative, of the last linear solve
    int inverted_tets = 0;                       // active tets of negative volume after the step
    bool rejected = false;                       // the step failed and the state is the one before it
    double estimate = 0;                         // relative displacement error, estimated
    std::vector<std::uint32_t> tets_by_level;    // [depth+1] active tets
    std::uint32_t free_vertices = 0, hanging_vertices = 0;
    int splits = 0, merges = 0;
    double energy_change = 0;                    // [J] that splits and merges added: kinetic, elastic, in gravity
    StepMilliseconds milliseconds;
    std::string warning;                         // one line for people; empty: all is well
};

class Simulation {
 public:
    /// The front starts at the coarsest allowed level, the state at rest.
    explicit Simulation(std::shared_ptr<const Model> model);
    /// The same with another front than the scene's, e.g. the finest level beside an adaptive run on one Model.
    Simulation(std::shared_ptr<const Model> model, const FrontSpec& front);
    ~Simulation();
    Simulation(Simulation&&) noexcept;
    Simulation& operator=(Simulation&&) noexcept;

    StepReport step();
    /// Moves everything to equilibrium under the loads of the present time, at rest, and adapts the front until it stays.
    /// Time stands still. The report's `converged` says whether equilibrium was found; an object that is not held has
    /// none under gravity.
    StepReport settle();
    /// Back to rest, time 0, the coarsest allowed front; pulls end; settings stay but for what the timeline sets.
    void reset();

    /// The present moment. Cost: the surface and the front.
    /// steps_per_second: what the caller measured, for FrameStatus. field: also computed, see Frame::field_values.
    [[nodiscard]] std::shared_ptr<const Frame> frame(double steps_per_second = 0, Field field = Field::none);
    /// Topologies of frames to come have greater epochs than this: when it takes another simulation's place before the same viewers.
    void number_fronts_from(std::uint32_t epoch);
    [[nodiscard]] const Model& model() const;

    // Commands; each acts from the next step on. Pulls are springs between a surface point and a target, named by the
    // caller's number. Throw InputError for a triangle out of range or a non-finite number, and then change nothing.
    void begin_pull(std::uint64_t pull, const SurfacePoint& point, const Vec3& target);
    void move_pull(std::uint64_t pull, const Vec3& target);  // unknown pull: nothing
    void end_pull(std::uint64_t pull);                       // unknown pull: nothing
    void set_gravity(const Vec3& gravity);                   // [m/s^2]
    void set_tolerance(double tolerance);                    // (0, 1]
    void set_budget(std::size_t tets, double milliseconds);  // per step, as FrontSpec; milliseconds 0: no limit
    // Shape, motion and time stay; the front begins as near to the present one as it then may. Cost: the tree.
    void set_order(int order);                               // 1 or 2; 2 needs levels
    void set_levels(int min_level, int max_level);           // of active tets, as FrontSpec; 0 <= min <= max
    /// Replaces all edits; what stays the same costs nothing, another scale, damping or pin costs the tree.
    void set_edits(const Edits& edits);
    [[nodiscard]] const Edits& edits() const;

    /// Puts the front's vertices at x with velocities v; hanging and pinned ones go where they must. x, v: [V of the tree]
    /// [m], [m/s]. Throws InputError for numbers that are not finite, and then changes nothing.
    void place(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v);

    /// Positions of all vertices of the tree, interpolated where nothing is simulated. Cost: the tree.
    [[nodiscard]] PerVertex<Vec3> all_positions() const;
    /// Of all active tets; linear [kg m/s] and angular about the origin [kg m^2/s].
    [[nodiscard]] Momentum momentum() const;
    struct Energy {
        double kinetic = 0, elastic = 0;  // [J]
    };
    [[nodiscard]] Energy energy() const;
    [[nodiscard]] const Front& front() const;
    /// Hash of the mutable state's bytes: equal states have equal hashes.
    [[nodiscard]] std::uint64_t hash() const;

    /// The complete mutable state, settings and pulls included; see snapshot.hpp. Cost: the tree.
    [[nodiscard]] std::string snapshot() const;
    /// Goes on from a snapshot of the same model and front. Throws InputError for any other bytes, and changes nothing then.
    /// name: of their file, for messages.
    void restore(std::string_view snapshot, const std::string& name = "");

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetfront
