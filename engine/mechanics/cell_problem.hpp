#pragma once
// The linear cell problem: C of a parent tet from the C of its eight children.
//
// Let node i of the ten move by u_i = F x_i + w_i. The fluctuations w minimise the children's mean energy
// 1/2 <e C e>, e_c = e + B_c w; then C_parent = <A_c^T C_c A_c> with A_c = 1 + B_c W, w = W e. What w may be is the
// method:
//
//   mean_strain     corners w_i = 0, and the children's mean deformation gradient is F: sum_i w_i (x) h_i = 0 with
//                   h_i = integral of node i's hat function times the normal. With h_ij proportional to G_i + G_j (G_k
//                   the gradients of the parent's barycentric coordinates) this says exactly that midpoints of opposite
//                   edges have the same w: nine unknowns.
//   isolated        corners w_i = 0, midpoints free: eighteen.
//   uniform_stress  all nodes free, mean deformation gradient F: w_i = -3 sum_j w_ij at the corners (the ones of the
//                   solutions without a translation): eighteen.
//
// So the Lagrange multipliers are eliminated by hand, and what is left is a positive definite system.
//
//     Sym6 c = solve_cell(CellProblem::mean_strain, gradients, children);

#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"
#include "engine/tree/tet_tree.hpp"

#include <array>

namespace tetfront {

/// How a parent's elasticity matrix follows from its children's.
/// Energies of the same strain are ordered: uniform_stress <= mean_strain <= average, and isolated <= mean_strain.
enum class CellProblem {
    average,      ///< midpoints follow the parent: volume average, Voigt upper bound
    mean_strain,  ///< corners fixed, midpoints relax, children's mean deformation gradient held equal to the parent's
    isolated,  ///< corners fixed, midpoints relax freely ([Imai] read literally); far too soft, for reproduction only
    uniform_stress,  ///< corners relax too, the surface carries one uniform traction: lower bound
};

/// gradients: of the parent's four barycentric coordinates, as columns [1/length, any unit: C does not depend on it].
/// children: their C in the order of child_nodes; each has an eighth of the parent's volume.
/// energy_shares: when given, the part of the energy that each child holds, averaged over all strains of equal energy
/// (the same in every frame); they sum to 1.
Sym6 solve_cell(CellProblem problem, const Eigen::Matrix<double, 3, 4>& gradients, const std::array<Sym6, 8>& children,
                std::array<double, 8>* energy_shares = nullptr);

/// Gradients of the barycentric coordinates of a tet, as columns [1/m].
Eigen::Matrix<double, 3, 4> corner_gradients(const std::array<Vec3, 4>& corners);

/// Gradient of fluctuation mode p in child c, as a combination of the parent's four gradients: modes[c].col(p).
/// mean_strain has 3 modes (opposite edges 01-23, 02-13, 03-12), isolated and uniform_stress 6 (tet_edges).
template <int Modes>
using ModeTable = std::array<Eigen::Matrix<double, 4, Modes>, 8>;
const ModeTable<3>& mean_strain_modes();
const ModeTable<6>& isolated_modes();
const ModeTable<6>& uniform_stress_modes();

}  // namespace tetfront
