#pragma once
// A 6x6 elasticity matrix and a valid strain range for every tet of every level, estimated bottom-up ([Imai] section
// 4).
//
// Leaves take C from the stiffness function. A parent's C comes from its eight children by a cell problem
// (cell_problem.hpp): corners follow the prescribed strain, edge midpoints relax, the mean stress of the children is
// the parent's stress.
//
//     LeafMaterials leaves = integrate_leaves(tree, stiffness_function);
//     ElasticityMatrices matrices = estimate_elasticity(tree, leaves, CellProblem::mean_strain);
//     Mat6 C = matrices.elasticity[t].matrix();        // [Pa]
//     PerTet<double> density = coarse_density(tree, leaves);

#include "engine/base/pooled.hpp"
#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"
#include "engine/material/stiffness.hpp"
#include "engine/mechanics/cell_sampling.hpp"
#include "engine/tree/tet_tree.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace tetfront {

/// What the leaves are made of, in the order of the tree's last level.
struct LeafMaterials {
    std::vector<Sym6> elasticity;           // [leaves] C [Pa], symmetric positive definite
    std::vector<double> density;            // [leaves] [kg/m^3] > 0
    std::vector<double> mass_damping;       // [leaves] [1/s] >= 0
    std::vector<double> stiffness_damping;  // [leaves] [s] >= 0
};

struct EstimationSettings {
    CellProblem problem = CellProblem::mean_strain;
    /// Set: C is fitted to nonlinear samples and valid ranges are found. Not set: the tangent at rest in closed form.
    std::optional<SamplingSettings> sampling;
};

/// How the estimation of one level went.
struct LevelReport {
    std::int32_t level = 0;
    std::int32_t finite_ranges = 0;      // tets of which some side of some strain has an end
    std::int64_t tets = 0, uniform = 0;  // uniform: all children alike, C copied
    /// Means over the tets of trace(C_average - C) / trace(C) and trace(C - C_uniform_stress) / trace(C): 0 at that
    /// bound.
    double below_average = 0, above_uniform_stress = 0;
    double mean_residual = 0, largest_residual = 0;  // of the fit against the tangent at rest, over the tangent's norm
    std::int64_t unfitted = 0;  // fits that were not positive definite: the tangent took their place
    double seconds = 0;
};

struct ElasticityMatrices {
    PooledPerTet<Sym6> elasticity;  // [T] C [Pa], symmetric positive definite
    /// [T] C_average - C_uniform_stress [Pa], both carried up from the leaves, positive semidefinite: what a coarse tet
    /// does not know about its material. Zero for leaves and wherever the material is uniform. Empty when it is
    /// zero everywhere.
    PooledPerTet<Sym6> bracket;
    /// [T] valid range of each Voigt strain component, [Imai] eq. (6): {min, max}; infinite where the linear law holds.
    /// Empty: all infinite. A parent's range never promises more than its children's do.
    PooledPerTet<StrainRange> valid_range;
    /// [T] Rayleigh coefficients [1/s], [s]; empty: all 0. Mass damping is the leaves' mean weighted by mass; stiffness
    /// damping is weighted by the energy that each child holds in the relaxed cell, so that the parent dissipates what
    /// its children would.
    PerTet<double> mass_damping, stiffness_damping;
    std::vector<LevelReport> report;  // [depth] of levels depth-1 .. 0; empty when the whole object is uniform
};

/// Fraction done, 0..1; called on the calling thread. May be empty.
using EstimationProgress = std::function<void(double fraction)>;

/// Integral mean of the stiffness function over each leaf. Throws InputError when the function is out of range
/// somewhere.
LeafMaterials integrate_leaves(const TetTree& tree, const StiffnessFunction& function,
                               const EstimationProgress& progress = {});

/// The estimate of every tet, level by level from the leaves up. A parent whose children all carry the same C copies it
/// (all methods but `isolated`) and is valid where all of its children are. Throws InputError for alphas out of range.
ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves,
                                       const EstimationSettings& settings, const EstimationProgress& progress = {});
/// The same without sampling.
inline ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves, CellProblem problem,
                                              const EstimationProgress& progress = {}) {
    return estimate_elasticity(tree, leaves, EstimationSettings{problem, {}}, progress);
}

/// Sets the Rayleigh coefficients of `matrices`, whose elasticity has been estimated. (estimate_elasticity calls it.)
void add_damping(const TetTree& tree, const LeafMaterials& leaves, CellProblem problem, ElasticityMatrices& matrices);

/// [T] density of every tet [kg/m^3]: the mean of its leaves.
PerTet<double> coarse_density(const TetTree& tree, const LeafMaterials& leaves);

}  // namespace tetfront
