#pragma once
// Implicit time steps on a front: backward Euler, the implicit midpoint rule or BDF2; Newton's method with a line search, PCG.
//
// All three solve for a velocity v of the free vertices (P: prolongation of the front, tied by restrict)
//
//     P^T [ M (v - v*) - h ( f(x* + h v) - D v + M g + loads ) ] = 0,        x = x* + h v
//
// with f the corotated internal force and D the Rayleigh damping of every tet.
//
//     backward Euler   x* = x0, v* = v0, h the time step: first order, damps whatever it does not resolve
//     midpoint         the same with half the step, then an extrapolation: second order, conserves linear and angular
//                      momentum to the tolerance, no numerical damping. Near the ground it is backward Euler
//     BDF2             x* = (4 x0 - x_earlier) / 3, v* alike, h = 2/3 of the step: second order, and damps what it does not
//                      resolve (L-stable). Its first step is one of backward Euler, and so is one after a step that was cut
//
// The equation says that the incremental potential (v - v* - h g)^T M (v - v* - h g) / 2 + elastic energy + (h/2) v^T D v -
// loads is stationary. Newton starts at v0 and uses the positive definite tangent M + h D + h^2 K, so every direction is
// one of descent, and each update is shortened until the potential falls (or, where damping turns with the object and
// there is no exact potential, until the slope along the update has halved). It stops at a tolerance or after a number of
// iterations. 1: the classical linearised step; when that makes the potential rise above that of standing still, so that it
// would invent energy, or when the ground is near, Newton goes on until it has something sound. Pinned vertices keep their place.
//
//     Implicit implicit;
//     implicit.build(front, elements, materials, pinned);             // after the front changed
//     ImplicitReport r = implicit.step(front, elements, state, loads, settings);

#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/multilevel.hpp"
#include "engine/mechanics/pcg.hpp"
#include "engine/mechanics/state.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

enum class ImplicitRule { backward_euler, midpoint, bdf2 };

struct ImplicitSettings {
    double time_step = 1.0 / 60;  // [s]
    ImplicitRule rule = ImplicitRule::backward_euler;
    int newton_iterations = 1;
    double newton_tolerance = 1e-4;  // of the residual, relative to the first one
    PcgLimits pcg;
};

struct ImplicitReport {
    bool finite = true;     // false: not finite, or no way down; the state was left as it was
    bool converged = true;  // every linear solve reached its tolerance, and Newton its own when it may iterate
    bool rescued = false;   // the linearised step was not sound; Newton went on
    int newton_iterations = 0;
    int solver_iterations = 0;
    int shortened = 0;      // updates that the line search cut
    double residual = 0;    // of the last linear solve, relative
    double assemble_milliseconds = 0, solve_milliseconds = 0;
};

class Implicit {
 public:
    /// materials: those that `elements` was built with.
    void build(const Front& front, const ElementSet& elements, const TetMaterials& materials,
               const PerVertex<std::uint8_t>& pinned);

    /// One time step. Afterwards `elements` holds strains, forces and energy at the new positions.
    ImplicitReport step(const Front& front, ElementSet& elements, State& state, const Loads& loads,
                        const ImplicitSettings& settings);

    /// The next build has other materials.
    void forget_materials() { preconditioner_.forget_materials(); }

    [[nodiscard]] const BlockMatrix& matrix() const { return matrix_; }

 private:
    /// What one step is about.
    struct Problem {
        const Front& front;
        ElementSet& elements;
        const Loads& loads;
        double h;  // [s]
    };
    /// The trial state in numbers.
    struct Trial {
        double potential = 0;  // [J]
        double scale = 0;      // [J] of its parts, for rounding
        double norm = 0;       // of the residual [kg m/s]
        [[nodiscard]] bool finite() const;
    };
    void set_base(const Front& front, const State& state, bool bdf2);
    void set_trial(const Problem& p);
    Trial evaluate(const Problem& p, bool tangent);
    void assemble(const Problem& p);
    bool solve(const Problem& p, const ImplicitSettings& settings, const State& state, bool first, ImplicitReport& report);
    bool search(const Problem& p, bool linearised, Trial& trial, bool& stuck, ImplicitReport& report);
    double standing_potential(const Problem& p, const State& state);
    [[nodiscard]] static ImplicitReport failed(ImplicitReport report);
    [[nodiscard]] double rounding(double h) const;
    void accept(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, ImplicitReport& report);

    BlockMatrix matrix_;
    Multilevel preconditioner_;
    Pcg pcg_;
    std::vector<VertexId> fixed_;  // free but pinned vertices of the front
    PerVertex<Vec3> base_x_, base_v_, trial_x_, trial_v_, inertia_, nodal_, point_diagonal_;
    double ceiling_ = 0;  // [J] of the potential of a sound step
    DofVector right_, update_, start_;  // minus the residual; Newton's update; velocities that a line search starts from
};

}  // namespace tetfront
