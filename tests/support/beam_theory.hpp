#pragma once
// What theory and publications say of beams, for tests and reports that hold the simulation against it.
//
//     timoshenko_tip(beam, 9810);                 // [m] deflection of a cantilever under its weight per volume
//     elastica_deflection(10);                    // 0.81061: Bisshopp & Drucker 1945
//     free_beam_frequencies(beam, 1000, 3);       // [Hz]

#include "engine/base/error.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace tetfront {

/// A prismatic beam of square section without lateral contraction (nu 0): beam theory holds best there.
struct SquareBeam {
    double length = 8, side = 1;  // [m]
    double young = 1e6;           // [Pa]

    [[nodiscard]] double area() const { return side * side; }
    [[nodiscard]] double second_moment() const { return side * side * side * side / 12; }
    /// Shear stiffness kappa G A [N], kappa = 5/6 of a rectangle at nu 0 (Cowper 1966).
    [[nodiscard]] double shear_stiffness() const { return 5.0 / 6 * young / 2 * area(); }
};

/// Tip deflection [m] of a cantilever under a weight per volume [N/m^3] (Timoshenko 1921).
inline double timoshenko_tip(const SquareBeam& b, double weight) {
    const double q = weight * b.area(), l2 = b.length * b.length;
    return q * l2 * l2 / (8 * b.young * b.second_moment()) + q * l2 / (2 * b.shear_stiffness());
}
/// The same under a force at the end [N].
inline double timoshenko_tip_of_end_load(const SquareBeam& b, double force) {
    return force * std::pow(b.length, 3) / (3 * b.young * b.second_moment()) + force * b.length / b.shear_stiffness();
}

/// Tip deflection over length of an inextensible cantilever with a dead load P at its end, P L^2 / (E I) = load (Bisshopp &
/// Drucker 1945), from the elliptic integrals that they tabulated.
inline double elastica_deflection(double load) {
    // k: modulus, k^2 = (1 + sin(tip angle)) / 2; sqrt(load) = K(k) - F(k, theta), sin theta = 1 / (k sqrt 2).
    const auto theta = [](double k) { return std::asin(std::min(1.0, 1 / (k * std::numbers::sqrt2))); };
    double low = 1 / std::numbers::sqrt2, high = 1 - 1e-15;
    for (int i = 0; i < 200; ++i) {
        const double k = (low + high) / 2;
        (std::comp_ellint_1(k) - std::ellint_1(k, theta(k)) < std::sqrt(load) ? low : high) = k;
    }
    const double k = (low + high) / 2;
    return 1 - 2 / std::sqrt(load) * (std::comp_ellint_2(k) - std::ellint_2(k, theta(k)));
}

/// The lowest bending frequencies [Hz] of a free Timoshenko beam, rotary inertia included (Huang 1961). density [kg/m^3].
inline std::vector<double> free_beam_frequencies(const SquareBeam& b, double density, int count) {
    const double l2 = b.length * b.length;
    const double r2 = b.second_moment() / (b.area() * l2), s2 = b.young * b.second_moment() / (b.shear_stiffness() * l2);
    // Zero at the natural values of b = omega sqrt(density A L^4 / (E I)), divided by cosh to stay in range.
    const auto equation = [&](double n) {
        const double root = std::sqrt((r2 - s2) * (r2 - s2) + 4 / (n * n));
        const double alpha = std::sqrt((root - (r2 + s2)) / 2), beta = std::sqrt((root + r2 + s2) / 2);
        const double factor = n / std::sqrt(1 - n * n * r2 * s2) * (n * n * r2 * (r2 - s2) * (r2 - s2) + (3 * r2 - s2));
        return 2 / std::cosh(n * alpha) - 2 * std::cos(n * beta) + factor * std::tanh(n * alpha) * std::sin(n * beta);
    };
    std::vector<double> found;
    const double step = 0.05;
    for (double n = 1; static_cast<int>(found.size()) < count; n += step) {
        ENSURE(n * n * r2 * s2 < 1, "beyond the beam's critical frequency");
        double low = n, high = n + step;
        if ((equation(low) < 0) == (equation(high) < 0)) continue;
        for (int i = 0; i < 60; ++i) {
            const double middle = (low + high) / 2;
            ((equation(middle) < 0) == (equation(low) < 0) ? low : high) = middle;
        }
        found.push_back(low * std::sqrt(b.young * b.second_moment() / (density * b.area())) / l2 / (2 * std::numbers::pi));
    }
    return found;
}

/// MacNeal & Harder 1985, the twisted beam: length 12, section 1.1 by 0.32, twisted by 90 degrees, E 29e6, nu 0.22; a unit
/// force at the tip along the width and along the thickness of the section there.
struct TwistedBeam {
    static constexpr double length = 12, width = 1.1, thickness = 0.32, young = 29e6, poisson = 0.22;
    static constexpr double in_plane = 5.424e-3, out_of_plane = 1.754e-3;
};

}  // namespace tetfront
