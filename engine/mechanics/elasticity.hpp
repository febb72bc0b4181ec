#pragma once
// A 6x6 elasticity matrix and a valid strain range for every tet of every level, estimated bottom-up ([Imai] section 4).
//
// Leaves take C from the stiffness function. A parent's C comes from its eight children by a cell problem: corners follow
// the prescribed strain, edge midpoints relax, the mean stress of the children is the parent's stress.
//
//     ElasticityMatrices matrices = estimate_elasticity(tree, leaf_material, CellProblem::mean_strain);
//     Mat6 C = matrices.elasticity[t].matrix();        // [Pa]

#include <functional>
#include <limits>
#include <string_view>

#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"
#include "engine/tree/tet_tree.hpp"

namespace tetfront {

/// How a parent's elasticity matrix follows from its children's (design: see engine/README.md).
enum class CellProblem {
    average,         ///< midpoints follow the parent: volume average, Voigt upper bound
    mean_strain,     ///< midpoints relax, mean deformation gradient of the children held equal to the parent's
    isolated,        ///< midpoints relax freely ([Imai] read literally); far too soft, for reproduction only
    uniform_stress,  ///< Reuss lower bound
};

struct ElasticityMatrices {
    PerTet<Sym6> elasticity;  // [T] C [Pa], symmetric positive definite
    /// [T] C_average - C_uniform_stress [Pa], positive semidefinite: what a coarse tet does not know about its material.
    /// Zero for leaves and wherever the material is uniform. Empty when the whole object is uniform.
    PerTet<Sym6> bracket;
    /// [T] valid range of each Voigt strain component, [Imai] eq. (6): {min, max}; infinite where the linear law holds.
    /// Empty: all infinite.
    PerTet<std::array<std::array<double, 2>, 6>> valid_range;
};

}  // namespace tetfront
