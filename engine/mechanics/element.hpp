#pragma once
// Element kernels: strain, stress, force and tangent of one tet (T = double) or of a pack of tets (T = Pack).
//
// Geometry is straight-sided, so the gradients G_k of the barycentric coordinates are constant. Linear and quadratic
// tets share every kernel: at a quadrature point a quadratic tet acts like a linear one with the effective corners
//
//     y_k = sum_i D_ki x_i,     D_ki = dN_i / dlambda_k,      F = sum_k y_k G_k^T
//
// so order is nothing but the constant matrix D (ElementOrder), with D = 1 for order 1.
//
// Corotated strain: F = U diag(s) V^T, S = V diag(s) V^T, strain S - 1 in the material frame, stress C (S - 1). Its first
// Piola-Kirchhoff stress is the exact derivative of the energy for any anisotropic C, hence free of torque: with the
// stress in the stretch frame t = V^T stress V,   P = U [ t_ij 2 s_i / (s_i + s_j) ] V^T.  (d(S^2) = d(F^T F).)
// Where s_i + s_j is small or negative (nearly flat or inverted) the denominator is held at `least_stretch_sum`.

#include <array>

#include "engine/base/simd.hpp"
#include "engine/base/voigt.hpp"
#include "engine/mechanics/svd3.hpp"
#include "engine/tree/tet_tree.hpp"

namespace tetfront {

template <class T>
using V3 = std::array<T, 3>;
template <class T>
using V6 = std::array<T, 6>;

inline constexpr double least_stretch_sum = 0.2;

/// Nodes, quadrature points (equal weights, barycentric coordinates) and the reference mass matrix of an order.
template <int Order>
struct ElementOrder;

template <>
struct ElementOrder<1> {
    static constexpr int nodes = 4, points = 1;
    static constexpr double at(int, int) { return 0.25; }
    /// Consistent mass over the tet's mass.
    static constexpr double mass(int i, int j) { return (i == j ? 2.0 : 1.0) / 20; }
    /// Effective corner k at a point: y_k = x_k.
    template <class T>
    static V3<T> effective_corner(const std::array<V3<T>, 4>& x, int, int k) {
        return x[static_cast<std::size_t>(k)];
    }
};

template <>
struct ElementOrder<2> {
    static constexpr int nodes = 10, points = 4;
    static constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;
    static constexpr double at(int point, int k) { return point == k ? near : far; }
    static constexpr double mass(int i, int j) {
        if (i > j) return mass(j, i);
        if (j < 4) return (i == j ? 6.0 : 1.0) / 420;
        const auto& ej = tet_edges[static_cast<std::size_t>(j - 4)];
        if (i < 4) return (ej[0] == i || ej[1] == i ? -4.0 : -6.0) / 420;
        if (i == j) return 32.0 / 420;
        const auto& ei = tet_edges[static_cast<std::size_t>(i - 4)];
        const bool touching = ei[0] == ej[0] || ei[0] == ej[1] || ei[1] == ej[0] || ei[1] == ej[1];
        return (touching ? 16.0 : 8.0) / 420;
    }
    /// Local edge between corners a and b, as in tet_edges.
    static constexpr int edge(int a, int b) {
        for (int e = 0; e < 6; ++e) {
            const auto& ends = tet_edges[static_cast<std::size_t>(e)];
            if ((ends[0] == a && ends[1] == b) || (ends[0] == b && ends[1] == a)) return e;
        }
        return -1;
    }
    /// y_k = (4 lambda_k - 1) x_k + sum_j 4 lambda_j x_kj.
    template <class T>
    static V3<T> effective_corner(const std::array<V3<T>, 10>& x, int point, int k) {
        V3<T> y;
        for (std::size_t c = 0; c < 3; ++c) {
            y[c] = constant<T>(4 * at(point, k) - 1) * x[static_cast<std::size_t>(k)][c];
            for (int j = 0; j < 4; ++j) {
                if (j != k) y[c] += constant<T>(4 * at(point, j)) * x[static_cast<std::size_t>(4 + edge(k, j))][c];
            }
        }
        return y;
    }
};

/// dN_i / dlambda_k at a quadrature point.
template <int Order>
constexpr double shape_derivative(int point, int k, int i) {
    using O = ElementOrder<Order>;
    if constexpr (Order == 1) {
        return i == k ? 1.0 : 0.0;
    } else {
        if (i < 4) return i == k ? 4 * O::at(point, k) - 1 : 0.0;
        const auto& e = tet_edges[static_cast<std::size_t>(i - 4)];
        if (e[0] == k) return 4 * O::at(point, e[1]);
        if (e[1] == k) return 4 * O::at(point, e[0]);
        return 0.0;
    }
}

/// G_1, G_2, G_3 as rows: gradients of the barycentric coordinates of corners 1..3 [1/m]; G_0 is minus their sum.
template <class T>
using Gradients = M3<T>;

Gradients<double> barycentric_gradients(const std::array<Vec3, 4>& rest);

/// F at a point, from node positions.
template <int Order, class T>
M3<T> deformation_gradient(const std::array<V3<T>, ElementOrder<Order>::nodes>& x, int point, const Gradients<T>& g) {
    using O = ElementOrder<Order>;
    const V3<T> y0 = O::effective_corner(x, point, 0);
    M3<T> f = M3<T>::zero();
    for (int k = 1; k < 4; ++k) {
        const V3<T> y = O::effective_corner(x, point, k);
        for (int r = 0; r < 3; ++r) {
            const T d = y[static_cast<std::size_t>(r)] - y0[static_cast<std::size_t>(r)];
            for (int c = 0; c < 3; ++c) f(r, c) += d * g(k - 1, c);
        }
    }
    return f;
}

/// Corotated strain S - 1 in Voigt form (engineering shear).
template <class T>
V6<T> corotated_strain(const Svd3<T>& d) {
    const std::array<T, 3> e = {d.s[0] - T(1), d.s[1] - T(1), d.s[2] - T(1)};
    V6<T> strain;
    for (std::size_t m = 0; m < 6; ++m) {
        const auto [i, j] = voigt_pairs[m];
        const T sum = e[0] * d.v(i, 0) * d.v(j, 0) + e[1] * d.v(i, 1) * d.v(j, 1) + e[2] * d.v(i, 2) * d.v(j, 2);
        strain[m] = m < 3 ? sum : sum + sum;
    }
    return strain;
}

/// The 21 upper entries of a symmetric 6x6 (see Sym6) for each lane, read from memory where they are needed: copies of them
/// would fill the registers.
template <class P>
struct StiffnessInMemory {
    const typename P::value_type* first;  // [21][lane]
    P operator[](std::size_t k) const { return load(first + k * P::size()); }
};

/// c strain, c as the 21 upper entries of a symmetric 6x6 (see Sym6). C: an array of T, or StiffnessInMemory.
template <class C, class T>
V6<T> hooke(const C& c, const V6<T>& strain) {
    V6<T> stress;
    for (int i = 0; i < 6; ++i) {
        T sum = c[Sym6::slot(i, 0)] * strain[0];
        for (int j = 1; j < 6; ++j) sum += c[Sym6::slot(i, j)] * strain[static_cast<std::size_t>(j)];
        stress[static_cast<std::size_t>(i)] = sum;
    }
    return stress;
}

template <class T>
T dot(const V6<T>& a, const V6<T>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}

template <class T>
M3<T> symmetric_from_voigt(const V6<T>& s) {
    return {{s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]}};
}

/// First Piola-Kirchhoff stress of the corotated energy (see the head of this file). stress: material frame, Voigt.
template <class T>
M3<T> piola_stress(const Svd3<T>& d, const V6<T>& stress) {
    M3<T> t = mul_at(d.v, mul(symmetric_from_voigt(stress), d.v));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (i == j) continue;
            const T si = d.s[static_cast<std::size_t>(i)], sj = d.s[static_cast<std::size_t>(j)];
            t(i, j) *= (si + si) / max(si + sj, constant<T>(least_stretch_sum));
        }
    }
    return mul_bt(mul(d.u, t), d.v);
}

/// Blocks A_kl = B(G_k)^T c B(G_l) of the rest-frame stiffness per volume, k, l = 1..3; block (k, l) at [k-1][l-1].
/// B maps the displacement of corner k to Voigt strain.
template <class C, class T>
std::array<std::array<M3<T>, 3>, 3> material_blocks(const C& c, const Gradients<T>& g) {
    // Rows of B(G)^T: displacement x touches strains xx, xz, xy; y: yy, yz, xy; z: zz, yz, xz.
    static constexpr int strain_of[3][3] = {{0, 4, 5}, {1, 3, 5}, {2, 3, 4}};
    static constexpr int gradient_of[3][3] = {{0, 2, 1}, {1, 2, 0}, {2, 1, 0}};
    std::array<std::array<M3<T>, 3>, 3> a;
    for (int l = 0; l < 3; ++l) {
        std::array<std::array<T, 3>, 6> cb;  // c B(G_l)
        for (int row = 0; row < 6; ++row) {
            for (int y = 0; y < 3; ++y) {
                T sum(0);
                for (int n = 0; n < 3; ++n) sum += c[Sym6::slot(row, strain_of[y][n])] * g(l, gradient_of[y][n]);
                cb[static_cast<std::size_t>(row)][static_cast<std::size_t>(y)] = sum;
            }
        }
        for (int k = 0; k <= l; ++k) {
            M3<T>& block = a[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)];
            for (int x = 0; x < 3; ++x) {
                for (int y = 0; y < 3; ++y) {
                    T sum(0);
                    for (int n = 0; n < 3; ++n) {
                        sum += g(k, gradient_of[x][n]) *
                               cb[static_cast<std::size_t>(strain_of[x][n])][static_cast<std::size_t>(y)];
                    }
                    block(x, y) = sum;
                }
            }
            if (k != l) {
                M3<T>& mirror = a[static_cast<std::size_t>(l)][static_cast<std::size_t>(k)];
                for (int x = 0; x < 3; ++x)
                    for (int y = 0; y < 3; ++y) mirror(y, x) = block(x, y);
            }
        }
    }
    return a;
}

}  // namespace tetfront
