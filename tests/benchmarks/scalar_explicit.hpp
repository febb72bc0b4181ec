#pragma once
// The yardstick: an explicit loop as a textbook has it (O'Brien & Hodgins 1999), in plain scalar double code, one thread.
//
// Linear tets, Green strain, isotropic St. Venant-Kirchhoff material, lumped mass, symplectic Euler. Nothing is vectorised
// by hand, reordered or approximated; nothing is made slow on purpose. `tetfront bench` divides its own times by this one's.
//
//     ScalarExplicit loop(positions, tets, pinned, {.young = 1e5, .poisson = 0.3, .density = 1000});
//     loop.frame(1.0 / 60);

#include <array>
#include <cstddef>
#include <vector>

#include "engine/base/types.hpp"

namespace tetfront {

class ScalarExplicit {
 public:
    struct Material {
        double young, poisson, density;  // [Pa], [0, 0.5), [kg/m^3]
    };
    /// pinned: [vertices], nonzero where a vertex does not move.
    ScalarExplicit(std::vector<Vec3> rest, std::vector<std::array<int, 4>> tets, std::vector<char> pinned, const Material& material);

    /// Internal forces at the present positions.
    void forces();
    /// One step of symplectic Euler under gravity.
    void step(double seconds);
    /// As many steps as are stable.
    void frame(double seconds);
    /// [s] below 2 / omega: omega^2 <= max over tets of 4 (lambda + 2 mu) / rho sum_i |G_i|^2.
    [[nodiscard]] double stable_step() const { return stable_step_; }
    [[nodiscard]] int substeps(double seconds) const;
    [[nodiscard]] std::size_t tets() const { return tets_.size(); }
    [[nodiscard]] const std::vector<Vec3>& positions() const { return x_; }
    [[nodiscard]] const std::vector<Vec3>& force() const { return f_; }

 private:
    double lambda_, mu_, stable_step_ = 0;
    std::vector<std::array<int, 4>> tets_;
    std::vector<char> pinned_;
    std::vector<Mat3> inverse_rest_;  // [tets] of the edges 1..3 as columns
    std::vector<double> volume_;      // [tets]
    std::vector<double> mass_;        // [vertices]
    std::vector<Vec3> x_, v_, f_;     // [vertices]
};

}  // namespace tetfront
