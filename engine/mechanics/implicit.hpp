#pragma once
// Implicit time steps on a front: backward Euler or the implicit midpoint rule, Newton's method, PCG.
//
// Backward Euler solves for the new velocity v of the free vertices (P: prolongation of the front, tied by restrict)
//
//     P^T [ M (v - v0) - h ( f(x0 + h v) - D v + M g + loads ) ] = 0,        x = x0 + h v
//
// with f the corotated internal force and D the Rayleigh damping of every tet. Newton starts at v0 and uses the positive
// definite tangent M + h D + h^2 K, so every direction is a descent direction; it stops at a tolerance or after a number
// of iterations (1: the classical linearised step).
// The midpoint rule is a backward Euler step of h/2 and an extrapolation: second order, conserves linear and angular
// momentum to the tolerance, no numerical damping. Pinned vertices keep their place.
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

struct ImplicitSettings {
    double time_step = 1.0 / 60;  // [s]
    bool midpoint = false;
    int newton_iterations = 1;
    double newton_tolerance = 1e-4;
    PcgLimits pcg;
};

struct ImplicitReport {
    bool finite = true;     // false: the state was left as it was
    bool converged = true;  // every linear solve reached its tolerance, and Newton its own when it may iterate
    int newton_iterations = 0;
    int solver_iterations = 0;
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

    [[nodiscard]] const BlockMatrix& matrix() const { return matrix_; }

 private:
    void set_trial(const Front& front, const State& state, double h);
    double residual(const Front& front, ElementSet& elements, const State& state, const Loads& loads, double h);

    BlockMatrix matrix_;
    Multilevel preconditioner_;
    Pcg pcg_;
    std::vector<VertexId> fixed_;                // free but pinned vertices of the front
    PerVertex<Vec3> trial_x_, trial_v_, inertia_, nodal_;
    DofVector right_, update_;
};

}  // namespace tetfront
