#pragma once
// Voigt convention: order xx yy zz yz xz xy with engineering shear, so that stress . strain is twice the energy density
// and a 6x6 elasticity matrix C maps strain to stress, [Imai] eq. (1).
//
//     Vec6 strain = voigt_strain(E);          // E symmetric 3x3, shear entries doubled
//     Vec6 stress = C * strain;               // [Pa]
//     Mat3 S = stress_tensor(stress);
//
// A symmetric 6x6 matrix is stored as its 21 upper entries, row by row: Sym6.

#include <array>

#include "engine/base/types.hpp"

namespace tetfront {

inline constexpr std::array<std::array<int, 2>, 6> voigt_pairs = {{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

/// E: symmetric 3x3 strain, dimensionless. Shear entries of the result are engineering shear (2 E_yz ...).
inline Vec6 voigt_strain(const Mat3& e) {
    return (Vec6() << e(0, 0), e(1, 1), e(2, 2), 2 * e(1, 2), 2 * e(0, 2), 2 * e(0, 1)).finished();
}
inline Mat3 strain_tensor(const Vec6& s) {
    return (Mat3() << s[0], s[5] / 2, s[4] / 2, s[5] / 2, s[1], s[3] / 2, s[4] / 2, s[3] / 2, s[2]).finished();
}
inline Vec6 voigt_stress(const Mat3& s) {
    return (Vec6() << s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(0, 2), s(0, 1)).finished();
}
inline Mat3 stress_tensor(const Vec6& s) {
    return (Mat3() << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]).finished();
}

/// Upper triangle of a symmetric 6x6 matrix, row by row: 00 01 .. 05 11 12 .. 55.
struct Sym6 {
    std::array<double, 21> upper{};

    static constexpr std::size_t slot(int row, int column) {
        const int i = row < column ? row : column, j = row < column ? column : row;
        return static_cast<std::size_t>(6 * i - i * (i - 1) / 2 + (j - i));
    }
    double operator()(int row, int column) const { return upper[slot(row, column)]; }

    static Sym6 from(const Mat6& m) {
        Sym6 s;
        for (int i = 0; i < 6; ++i)
            for (int j = i; j < 6; ++j) s.upper[slot(i, j)] = (m(i, j) + m(j, i)) / 2;
        return s;
    }
    [[nodiscard]] Mat6 matrix() const {
        Mat6 m;
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) m(i, j) = (*this)(i, j);
        return m;
    }
    friend bool operator==(const Sym6&, const Sym6&) = default;
};

/// Isotropic elasticity matrix. young [Pa] > 0, poisson in (-1, 0.5).
inline Mat6 isotropic_elasticity(double young, double poisson) {
    const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
    Mat6 c = Mat6::Zero();
    c.topLeftCorner<3, 3>().setConstant(lambda);
    c.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
    return c;
}

}  // namespace tetfront
