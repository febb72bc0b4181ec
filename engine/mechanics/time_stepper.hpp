#pragma once
// One time step of a scene that cannot break the state: tries the step, and in 2, 4, 8, 16 parts when it fails (numbers that
// are not finite, or an object torn apart); when nothing helps the state is the one before. Also the search for a place
// of rest.
//
//     TimeStepper stepper;
//     stepper.build(front, elements, materials, pinned);                    // after the front changed
//     Advance a = stepper.advance(front, elements, state, settings, size,
//                                 [&](Loads& loads, double h) { ... });     // fills the loads of the present state, of h [s]
//     if (!a.done) ...                                                      // the object stands where it stood
//
// Integrator::automatic takes the implicit or the explicit step, whichever it expects to cost less time. Both costs are
// measured in the run, per tet: explicit ones per substep (a first force evaluation is timed for it), implicit ones per
// step; now and then the other one is tried again where they are close. So its choice, and with it the bits of the
// result, depend on the machine and on what else it does: name one of the two for runs that can be repeated.

#include <functional>
#include <optional>
#include <vector>

#include "engine/mechanics/explicit.hpp"
#include "engine/mechanics/implicit.hpp"
#include "engine/mechanics/state.hpp"

namespace tetfront {

enum class Integrator { implicit, explicit_euler, automatic };

/// What a time step did.
struct Advance {
    bool done = true;       // false: nothing worked, the state is as before
    int parts = 1;          // the step was cut in so many
    bool converged = true;  // every solve of the last try reached its tolerance
    int newton_iterations = 0;
    int solver_iterations = 0;
    bool rescued = false;   // a linearised step was not sound, Newton went on
    int substeps = 0;       // explicit ones; 0: the step was implicit
    bool too_stiff = false; // not done because it would take more than `most_substeps`
    double residual = 0;    // of the last linear solve, relative
    double assemble_milliseconds = 0, solve_milliseconds = 0;
};

/// Fills empty loads with those of the present state, for a step of so many seconds.
using LoadsOfStep = std::function<void(Loads& loads, double time_step)>;

class TimeStepper {
 public:
    static constexpr double most_substeps = 20000;

    /// materials: those that `elements` was built with. pinned: [V of the tree] nonzero: does not move. All but `materials` itself
    /// have to stay until the next build: each integrator is set up when it is first needed.
    void build(const Front& front, const ElementSet& elements, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned,
               Integrator integrator = Integrator::implicit);

    /// Advances by settings.time_step. size: [m] of the object. loads: called before each part, on empty loads.
    /// Afterwards `elements` holds strains, forces and energy of the state.
    Advance advance(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, double size,
                    const LoadsOfStep& loads);

    /// Moves the state to equilibrium under its loads, at rest: steps of backward Euler from standing still, each twice as
    /// long as the one before, end up as Newton steps of the static problem. converged: motion has died away.
    Advance settle(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, double size,
                   const LoadsOfStep& loads);

    /// The next build has other materials, or another order.
    void forget_materials() {
        implicit_.forget_materials();
        explicit_.forget_materials();
    }
    /// What automatic does next.
    [[nodiscard]] bool prefers_explicit(double time_step);

 private:
    struct Saved {
        Vec3 x, v, a, earlier_x, earlier_v;
    };
    void save(const Front& front, const State& state);
    void undo(const Front& front, State& state) const;
    [[nodiscard]] bool torn_apart(const Front& front, const State& state, double size) const;
    void collect(const LoadsOfStep& loads, double time_step);
    bool explicit_part(const Front& front, ElementSet& elements, State& state, double time_step, int parts, Advance& a);
    bool implicit_part(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, Advance& a);

    struct BuiltFor {
        const Front& front;
        const ElementSet& elements;
        TetMaterials materials;
        const PerVertex<std::uint8_t>& pinned;
    };
    Implicit& built_implicit();
    Explicit& built_explicit();

    Integrator integrator_ = Integrator::implicit;
    std::optional<BuiltFor> built_for_;
    bool implicit_built_ = false, explicit_built_ = false;  // for it
    Implicit implicit_;
    Explicit explicit_;
    Loads loads_;
    bool had_earlier_ = false;
    std::vector<Saved> saved_;  // [vertices of the front] before the step
    // Of automatic: measured costs [ms] per tet, 0 not known; steps since the dearer kind was tried.
    double implicit_cost_ = 0, substep_cost_ = 0;
    bool last_explicit_ = false;
    int untried_ = 0;
};

}  // namespace tetfront
