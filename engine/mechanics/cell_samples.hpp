#pragma once
// The samples behind a coarse tet's elasticity matrix, one by one, to look at: the dots of [Imai] figure 3.
//
//     for (const CellSample& s : sample_curve(CellProblem::mean_strain, gradients, children, 0, {-0.1, 0.1}))
//         plot(s.alpha, s.stress[0]);

#include "engine/mechanics/cell_problem.hpp"

#include <span>
#include <vector>

namespace tetfront {

struct CellSample {
    double alpha = 0;
    Vec6 stress = Vec6::Zero();  // second Piola-Kirchhoff, of the parent [unit of the children's C]
};

/// The nonlinear cell problem of cell_sampling.hpp at Green strains alpha along Voigt component m, 0..5. alphas: not 0, in
/// (-0.49, 0.49). Samples where Newton does not converge or a child turns inside out are left out. problem: any but
/// average, which needs no samples.
std::vector<CellSample> sample_curve(CellProblem problem, const Eigen::Matrix<double, 3, 4>& gradients,
                                     const std::array<Sym6, 8>& children, int m, std::span<const double> alphas);

}  // namespace tetfront
