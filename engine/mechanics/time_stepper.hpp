#pragma once
// One time step of a scene that cannot break the state: tries the step, and in 2, 4, 8, 16 parts when it fails (numbers that
// are not finite, or an object torn apart); when nothing helps the state is the one before.
//
//     TimeStepper stepper;
//     stepper.build(front, elements, materials, pinned);                    // after the front changed
//     Advance a = stepper.advance(front, elements, state, settings, size,
//                                 [&](Loads& loads) { ... });               // fills the loads of the present state
//     if (!a.done) ...                                                      // the object stands where it stood

#include <array>
#include <functional>
#include <vector>

#include "engine/mechanics/implicit.hpp"
#include "engine/mechanics/state.hpp"

namespace tetfront {

/// What a time step did.
struct Advance {
    bool done = true;       // false: nothing worked, the state is as before
    int parts = 1;          // the step was cut in so many
    bool converged = true;  // every solve of the last try reached its tolerance
    int newton_iterations = 0;
    int solver_iterations = 0;
    bool rescued = false;   // a linearised step was not sound, Newton went on
    double residual = 0;    // of the last linear solve, relative
    double assemble_milliseconds = 0, solve_milliseconds = 0;
};

class TimeStepper {
 public:
    /// materials: those that `elements` was built with. pinned: [V of the tree] nonzero: does not move.
    void build(const Front& front, const ElementSet& elements, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned);

    /// Advances by settings.time_step. size: [m] of the object. loads: called before each part, on empty loads.
    /// Afterwards `elements` holds strains, forces and energy of the state.
    Advance advance(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, double size,
                    const std::function<void(Loads&)>& loads);

 private:
    struct Saved {
        Vec3 x, v, a, earlier_x, earlier_v;
    };
    void save(const Front& front, const State& state);
    void undo(const Front& front, State& state) const;
    [[nodiscard]] bool torn_apart(const Front& front, const State& state, double size) const;

    Implicit implicit_;
    Loads loads_;
    bool had_earlier_ = false;
    std::vector<Saved> saved_;  // [vertices of the front] before the step
};

}  // namespace tetfront
