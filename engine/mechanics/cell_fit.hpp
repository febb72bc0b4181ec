#pragma once
// A straight line through the origin fitted to samples of which some are off: the slope that the most samples agree
// with.
//
// A sample (alpha, sigma) agrees with slope c when it satisfies [Imai] (4) or (5):
//     |alpha c - sigma| < max(T1 |alpha c|, T2).
// Every sample's own slope is a candidate; the one with the most agreeing samples wins and is then fitted to them by
// least squares. Least squares over all samples follows the outliers; the median of slopes (Theil-Sen) withstands half
// of them, but is led astray when the samples of one side are missing, because a curve then has no middle at the
// origin.
//
//     const double c = fit_slope(alphas, stresses, {1e-2, 1e-4 * stiffness});

#include <span>

namespace tetfront {

struct LinearLaw {
    double relative = 1e-2;  // T1
    double absolute = 1e-4;  // T2, in the unit of sigma

    /// |alpha c - sigma| over what is allowed: below 1 the sample agrees.
    [[nodiscard]] double deviation(double alpha, double slope, double sigma) const {
        const double line = alpha * slope, off = line < sigma ? sigma - line : line - sigma;
        const double allowed = relative * (line < 0 ? -line : line);
        return off / (allowed < absolute ? absolute : allowed);
    }
};

/// alphas: not zero. Same length, at least one. Independent of the samples' order, up to rounding.
double fit_slope(std::span<const double> alphas, std::span<const double> sigmas, const LinearLaw& law);

}  // namespace tetfront
