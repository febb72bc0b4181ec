#pragma once
// Strain measures: what the element kernels need to know of a deformation gradient F, for T = double and T = Pack.
//
//     corotated   S - 1,              F = R S the polar decomposition         piola_stress() in element.hpp
//     green       (F^T F - 1) / 2,    St. Venant-Kirchhoff material           P = F sigma, sigma the second Piola-Kirchhoff stress
//
// Both have the strain rate sym(frame^T dF) and the material part of the tangent frame A_kl frame^T with A_kl as in
// material_blocks(): frame is R or F. The corotated tangent leaves the derivatives of R out and is positive semidefinite.
// That of Green has the geometric part (G_k . sigma G_l) 1 besides; compression makes it indefinite, so Newton gets the
// part of sigma with eigenvalues >= 0 (geometric_stress). Where nothing is compressed the tangent is exact.
//
// Green strain needs no decomposition, which makes its forces several times cheaper. But F and an inverted F have the same
// strain, and a tet that is squeezed to half its length gets softer: use it for moderate strains and explicit steps.
//
//     const GreenPoint<Pack> point(f);
//     stress = hooke(c, point.strain());  p = point.piola(stress);

#include "engine/base/strain_measure.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

template <class T>
class CorotatedPoint {
 public:
    static constexpr bool has_geometric_stress = false;

    explicit CorotatedPoint(const M3<T>& f) : d_(svd3(f)) {}
    [[nodiscard]] V6<T> strain() const { return corotated_strain(d_); }
    [[nodiscard]] M3<T> piola(const V6<T>& stress) const { return piola_stress(d_, stress); }
    [[nodiscard]] M3<T> frame() const { return mul_bt(d_.u, d_.v); }
    /// Negative where the tet is inverted.
    [[nodiscard]] T orientation() const { return d_.s[2]; }

 private:
    Svd3<T> d_;
};

template <class T>
class GreenPoint {
 public:
    static constexpr bool has_geometric_stress = true;

    explicit GreenPoint(const M3<T>& f) : f_(f) {}
    [[nodiscard]] V6<T> strain() const {
        V6<T> e;
        for (std::size_t m = 0; m < 6; ++m) {
            const auto [i, j] = voigt_pairs[m];
            const T product = f_(0, i) * f_(0, j) + f_(1, i) * f_(1, j) + f_(2, i) * f_(2, j);
            e[m] = m < 3 ? constant<T>(0.5) * (product - T(1)) : product;
        }
        return e;
    }
    [[nodiscard]] M3<T> piola(const V6<T>& stress) const { return mul(f_, symmetric_from_voigt(stress)); }
    [[nodiscard]] const M3<T>& frame() const { return f_; }
    [[nodiscard]] T orientation() const {
        return f_(0, 0) * (f_(1, 1) * f_(2, 2) - f_(1, 2) * f_(2, 1)) - f_(0, 1) * (f_(1, 0) * f_(2, 2) - f_(1, 2) * f_(2, 0)) +
               f_(0, 2) * (f_(1, 0) * f_(2, 1) - f_(1, 1) * f_(2, 0));
    }
    /// V max(L, 0) V^T of the stress V L V^T.
    [[nodiscard]] static M3<T> geometric_stress(const V6<T>& stress) {
        M3<T> a = symmetric_from_voigt(stress), v = M3<T>::identity();
        for (int sweep = 0; sweep < 5; ++sweep) {
            detail::jacobi<0, 1>(a, v);
            detail::jacobi<0, 2>(a, v);
            detail::jacobi<1, 2>(a, v);
        }
        M3<T> scaled = v;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) scaled(i, j) *= max(a(j, j), T(0));
        return mul_bt(scaled, v);
    }

 private:
    M3<T> f_;
};

}  // namespace tetfront
