#pragma once
// What a Simulation owns; for the files that implement it. simulation_commands.cpp holds commands and answers, simulation_edits.cpp
// those that change what is simulated, simulation_step.cpp what a step does, simulation_snapshot.cpp saves and restores. Mutable
// state that a snapshot must keep: front, state, adaptivity, gravity, pulls, steps, the settings (edits and the order are the
// caller's: it sets them before; tolerance and budget), milliseconds_per_tet. All else follows from it and from the model.

#include <chrono>

#include "engine/mechanics/adaptivity.hpp"
#include "engine/mechanics/time_stepper.hpp"
#include "engine/simulation/frame_builder.hpp"
#include "engine/simulation/pins.hpp"
#include "engine/simulation/pulls.hpp"
#include "engine/simulation/simulation.hpp"
#include "engine/simulation/snapshot.hpp"

namespace tetfront {

/// Gives the vertices that the front does not have their place in it. Cost: the tree.
void interpolate_absent(const Front& front, PerVertex<Vec3>& field);

/// A constant force at a point of the object.
struct PointLoad {
    Attachment at;
    Vec3 force;  // [N]
};

struct Simulation::Impl {
    Impl(std::shared_ptr<const Model> m, const FrontSpec& spec);

    /// State at rest on the front as it is, at time 0.
    void start();
    void place(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v);
    StepReport step();
    StepReport settle();

    /// The parts of a report that describe the present state.
    void describe(StepReport& r) const;
    void set_edits(const Edits& wanted);
    /// Another order, or other levels.
    void set_front(const FrontSpec& wanted);
    /// The model's, or with the edits' scale and damping.
    [[nodiscard]] const ElasticityMatrices& matrices() const { return edited_matrices ? *edited_matrices : model->matrices; }

    /// Loads of the present state, for a step of so many seconds.
    void add_loads(Loads& loads, double time_step) const;
    /// What of the loads is a force that somebody or the scene set, for frames.
    [[nodiscard]] std::vector<FrameForce> seen_forces() const;
    /// Of the last evaluation of `elements` [J]: elastic, kinetic, and in the gravity field up to a constant.
    [[nodiscard]] double total_energy() const;

    [[nodiscard]] Snapshot snapshot() const;
    void restore(const Snapshot& snapshot, const std::string& name);

    std::shared_ptr<const Model> model;
    FrontSpec front_spec;
    Front front;
    Pins pins;
    Adaptivity adaptivity;  // refers to pins.unresolved
    AdaptivitySettings adapt_settings;
    ElementSet elements;
    TimeStepper stepper;
    ImplicitSettings settings;
    Integrator integrator = Integrator::implicit;
    State state;
    FrameBuilder frames;
    Vec3 gravity;
    Pulls pulls;
    Edits edits;
    std::shared_ptr<const ElasticityMatrices> edited_matrices;  // null: the model's
    std::vector<PointLoad> edit_forces;                         // of edits.forces
    double time = 0;
    std::uint64_t steps = 0;
    std::size_t budget_tets = 0;
    double budget_milliseconds = 0;   // 0: none
    double milliseconds_per_tet = 0;  // of recent steps, the costliest
    StepReport report;

 private:
    /// Splits tets that miss a pinned region, until none does.
    void resolve_pins();
    /// What follows from the front and the pins.
    void rebuild();
    /// After the front or the materials are others than those that adaptivity knows.
    void measure_anew();
    /// What the scene's timeline has for the step that begins. Cost: the timeline; the tree only when a pin is released.
    void apply_timeline();
    /// Gives vertices that appeared their place and velocity, and hanging ones theirs.
    void transfer(const Front::Change& change);
    /// Turns the budget into a number of tets. A budget of time uses what tets have cost at most lately, changes of the
    /// front included.
    void apply_budget();
    void adapt(StepReport& r);
    static void describe(const Advance& a, StepReport& r);
    /// [ms] since the last call.
    double lap();

    PerVertex<Vec3> scratch_;
    std::chrono::steady_clock::time_point phase_start_;
};

}  // namespace tetfront
