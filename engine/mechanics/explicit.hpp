#pragma once
// Explicit time steps on a front: symplectic Euler in as many substeps as stay stable (O'Brien & Hodgins 1999, the paper's
// integrator), with a lumped mass. No system is solved: cheap for soft objects and coarse fronts.
//
//     x <- x + d v,      v <- v + d ( m^-1 P^T f(x, v) + g ),      d = step / substeps
//
// The mass of every tet is lumped to its vertices (order 2: as if over its eight children, so that corners get some) and
// moved to the free vertices by P^T, as forces are. The stable substep comes from the active tets: for K x = w^2 M x of a
// single tet at rest the largest w bounds that of the whole (Irons & Treharne 1971), times a factor for hanging
// vertices whose rows have negative weights; with Rayleigh damping d <= (2/w) (sqrt(1 + z^2) - z), z = (a/w + b w)/2.
// Springs of pulls and contacts act implicitly, each by itself, and put no limit on the substep. Forces are in single precision
// while strains are far above its rounding, but in the last substep, whose strains others read.
//
//     Explicit integrator;
//     integrator.build(front, materials, pinned);                           // after the front changed
//     ExplicitReport r = integrator.step(front, elements, state, loads, time_step);

#include <vector>

#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/state.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

struct ExplicitReport {
    bool finite = true;  // false: the state is lost
    int substeps = 0;
};

class Explicit {
 public:
    /// materials: those that `elements` was built with; what is known of a tet is kept until forget_materials().
    void build(const Front& front, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned);
    /// The next build has other materials, or another order.
    void forget_materials() { frequency2_ = {}; }
    /// [s] the longest substep that stays stable.
    [[nodiscard]] double stable_step() const { return stable_step_; }
    [[nodiscard]] double substeps(double time_step) const;
    /// refine: substeps shorter by this factor. `elements` as they were evaluated at the state; afterwards `elements` holds strains, forces and energy of the state.
    ExplicitReport step(const Front& front, ElementSet& elements, State& state, const Loads& loads, double time_step, int refine = 1);
    /// Mass of a free vertex [kg].
    [[nodiscard]] double mass(VertexId v) const { return mass_[v]; }

 private:
    struct FreeWeight {
        VertexId vertex;
        double weight;
    };
    void lump(const Front& front, const TetMaterials& materials);
    /// P^T of a point's weights, appended to weights_.
    void add_free_weights(const Front& front, const Front::Point& at);
    void apply_springs(const Loads& loads, State& state, double d);
    void apply_contacts(const Loads& loads, State& state, double d);
    /// Place and velocity of the point whose weights are weights_[begin, end).
    struct PointMotion {
        Vec3 x, v;
        double mobility;  // [1/kg] change of velocity for an impulse
    };
    [[nodiscard]] PointMotion motion_of(std::size_t begin, std::size_t end, const State& state) const;
    void push(std::size_t begin, std::size_t end, const Vec3& impulse, State& state) const;

    double stable_step_ = 0;
    double stiffness_ = 0;             // [J] energy of unit strains, about
    double amplification_ = 1;         // of w^2 by hanging rows
    PerTet<float> frequency2_;         // [T of the tree] w^2 [1/s^2]; 0: not known yet
    PerVertex<double> mass_, spread_, weight_sum_;  // [V of the tree], valid for the front's
    PerVertex<Vec3> nodal_;
    std::vector<VertexId> moving_;     // free and not pinned
    PerVertex<std::uint8_t> moves_;    // [V of the tree]
    std::vector<FreeWeight> weights_;  // of all springs and contacts, one after another
    std::vector<std::size_t> weights_end_;
};

/// w^2 [1/s^2] of the stiffest mode of a tet of the given order, alone at rest, with its lumped mass. corners: at rest [m],
/// c: [Pa], density: [kg/m^3].
double largest_frequency2(int order, const std::array<Vec3, 4>& corners, const Sym6& c, double density);

}  // namespace tetfront
