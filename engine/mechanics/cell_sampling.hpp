#pragma once
// The nonlinear cell problem ([Imai] 4.1 to 4.3): stretch a parent tet by alpha along each Voigt strain m, relax its
// edge midpoints, read the stress, fit a line, and note how far the line holds.
//
// The children carry Green strain and St. Venant-Kirchhoff's law with their own C: W_c = 1/2 E_c . C_c E_c. The
// parent's deformation gradient is F = (1 + 2 alpha e_m)^(1/2); the children's are F_c = F + sum_p q_p (x) g_cp with
// the modes of cell_problem.hpp. Newton's method with line search finds the q of least energy, starting from the
// extrapolated samples before; its factorisation is kept while it converges fast. The parent's second Piola-Kirchhoff
// stress is S = F^-1 <P_c>, the derivative of the mean energy with respect to the parent's Green strain: the mean that
// Hill and Mandel's condition asks for.
//
// A side of a strain ends where the samples leave the line, where a child leaves its own valid range, where Newton does
// not converge or where a child turns inside out.
//
//     SampledCell cell = sample_cell(CellProblem::mean_strain, gradients, children, nullptr, settings);

#include "engine/mechanics/cell_problem.hpp"

#include <array>
#include <limits>
#include <vector>

namespace tetfront {

/// {min, max} of each Voigt component of the strain.
using StrainRange = std::array<std::array<double, 2>, 6>;
inline constexpr StrainRange unbounded_range = [] {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    StrainRange range{};
    for (auto& r : range) r = {-infinity, infinity};
    return range;
}();

/// Nonlinear sampling of the cell problem.
struct SamplingSettings {
    /// Magnitudes of the Green strains that are sampled on both sides, ascending, in (0, 0.49).
    std::vector<double> alphas = {0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32};
    double relative_tolerance = 1e-2;  // T1 of (4)
    double stress_tolerance = 1e-4;    // T2 of (5), in units of sqrt(C_jj C_mm) for stress j and strain m
};

struct SampledCell {
    Sym6 elasticity;          // [Pa] the fitted matrix, symmetric positive definite
    StrainRange valid_range;  // contains 0
    double residual = 0;      // largest difference of the fitted and the tangent matrix, over the tangent's norm
    int samples = 0, newton_iterations = 0;
    bool fitted = true;  // false: the fit was not positive definite and the tangent at rest took its place
};

/// gradients: as in solve_cell. children: their C. child_ranges: their valid ranges, null for unbounded ones.
SampledCell sample_cell(CellProblem problem, const Eigen::Matrix<double, 3, 4>& gradients,
                        const std::array<Sym6, 8>& children, const std::array<StrainRange, 8>* child_ranges,
                        const SamplingSettings& settings);

}  // namespace tetfront
