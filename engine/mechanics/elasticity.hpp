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

#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"
#include "engine/material/stiffness.hpp"
#include "engine/mechanics/cell_problem.hpp"
#include "engine/tree/tet_tree.hpp"

#include <functional>
#include <vector>

namespace tetfront {

/// What the leaves are made of, in the order of the tree's last level.
struct LeafMaterials {
    std::vector<Sym6> elasticity;           // [leaves] C [Pa], symmetric positive definite
    std::vector<double> density;            // [leaves] [kg/m^3] > 0
    std::vector<double> mass_damping;       // [leaves] [1/s] >= 0
    std::vector<double> stiffness_damping;  // [leaves] [s] >= 0
};

struct ElasticityMatrices {
    PerTet<Sym6> elasticity;  // [T] C [Pa], symmetric positive definite
    /// [T] C_average - C_uniform_stress [Pa], both carried up from the leaves, positive semidefinite: what a coarse tet
    /// does not know about its material. Zero for leaves and wherever the material is uniform. Empty when the whole
    /// object is uniform.
    PerTet<Sym6> bracket;
    /// [T] valid range of each Voigt strain component, [Imai] eq. (6): {min, max}; infinite where the linear law holds.
    /// Empty: all infinite.
    PerTet<std::array<std::array<double, 2>, 6>> valid_range;
};

/// Fraction done, 0..1; called on the calling thread. May be empty.
using EstimationProgress = std::function<void(double fraction)>;

/// Integral mean of the stiffness function over each leaf. Throws InputError when the function is out of range
/// somewhere.
LeafMaterials integrate_leaves(const TetTree& tree, const StiffnessFunction& function,
                               const EstimationProgress& progress = {});

/// The linear estimate of every tet, level by level from the leaves up. A parent whose children all carry the same C
/// copies it (all methods but `isolated`). valid_range stays empty.
ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves, CellProblem problem,
                                       const EstimationProgress& progress = {});

/// [T] density of every tet [kg/m^3]: the mean of its leaves.
PerTet<double> coarse_density(const TetTree& tree, const LeafMaterials& leaves);

}  // namespace tetfront
