#pragma once
// Signed singular value decomposition of a 3x3 matrix, defined for EVERY finite matrix, also flat, inverted and zero.
//
//     F = U diag(s) V^T,   U and V rotations (det +1),   s0 >= s1 >= |s2|,   sign of s2 = sign of det F
//
// so the rotation R = U V^T of the polar decomposition never reflects: an inverted tet has one negative stretch (Irving,
// Teran, Fedkiw 2004). Branch-free: Jacobi on F^T F, then a QR of F V by Givens rotations (McAdams et al. 2011), so that
// one call handles a pack of matrices. Where F leaves V open (equal or zero singular values) any valid V is returned.
//
//     Svd3<double> d = svd3(f);     // f: row-major 3x3
//     d.u, d.v, d.s

#include <array>
#include <utility>

#include "engine/base/simd.hpp"

namespace tetfront {

/// Row-major 3x3 matrix of scalars or packs.
template <class T>
struct M3 {
    std::array<T, 9> m;
    T& operator()(int r, int c) { return m[static_cast<std::size_t>(3 * r + c)]; }
    const T& operator()(int r, int c) const { return m[static_cast<std::size_t>(3 * r + c)]; }

    static M3 identity() { return {{T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)}}; }
    static M3 zero() { return {{T(0), T(0), T(0), T(0), T(0), T(0), T(0), T(0), T(0)}}; }
};

/// a b
template <class T>
M3<T> mul(const M3<T>& a, const M3<T>& b) {
    M3<T> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
    return r;
}
/// a b^T
template <class T>
M3<T> mul_bt(const M3<T>& a, const M3<T>& b) {
    M3<T> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r(i, j) = a(i, 0) * b(j, 0) + a(i, 1) * b(j, 1) + a(i, 2) * b(j, 2);
    return r;
}
/// a^T b
template <class T>
M3<T> mul_at(const M3<T>& a, const M3<T>& b) {
    M3<T> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r(i, j) = a(0, i) * b(0, j) + a(1, i) * b(1, j) + a(2, i) * b(2, j);
    return r;
}

template <class T>
struct Svd3 {
    M3<T> u, v;
    std::array<T, 3> s;
};

namespace detail {

/// One Jacobi rotation that zeroes a(p, q) of the symmetric a and updates the eigenvectors v (columns).
template <int p, int q, class T>
void jacobi(M3<T>& a, M3<T>& v) {
    constexpr int r = 3 - p - q;
    const T d = a(q, q) - a(p, p), twice = a(p, q) + a(p, q);
    const T root = sqrt(d * d + twice * twice);
    const T sign = select(d < T(0), T(-1), T(1));
    const T t = twice * sign / (abs_of(d) + root + constant<T>(nearly_zero<T> * nearly_zero<T>));
    const T c = T(1) / sqrt(T(1) + t * t), s = t * c;
    const T apq = a(p, q);
    a(p, p) -= t * apq;
    a(q, q) += t * apq;
    a(p, q) = T(0);
    a(q, p) = T(0);
    const T arp = a(r, p), arq = a(r, q);
    a(r, p) = c * arp - s * arq;
    a(p, r) = a(r, p);
    a(r, q) = s * arp + c * arq;
    a(q, r) = a(r, q);
    for (int i = 0; i < 3; ++i) {
        const T vip = v(i, p), viq = v(i, q);
        v(i, p) = c * vip - s * viq;
        v(i, q) = s * vip + c * viq;
    }
}

/// Swaps columns i and j of b and v where n[i] < n[j], negating one so that det v stays +1.
template <int i, int j, class T>
void order_columns(std::array<T, 3>& n, M3<T>& b, M3<T>& v) {
    const auto swap = n[i] < n[j];
    for (M3<T>* m : {&b, &v}) {
        for (int r = 0; r < 3; ++r) {
            const T x = (*m)(r, i), y = (*m)(r, j);
            (*m)(r, i) = select(swap, y, x);
            (*m)(r, j) = select(swap, -x, y);
        }
    }
    const T x = n[i], y = n[j];
    n[i] = select(swap, y, x);
    n[j] = select(swap, x, y);
}

/// Givens rotation of rows p < q that zeroes b(q, p); accumulated in u (b = u^T f v). Identity when both are zero.
template <int p, int q, class T>
void givens(M3<T>& b, M3<T>& u) {
    const T x = b(p, p), y = b(q, p);
    const T n = sqrt(x * x + y * y);
    const auto tiny = n < constant<T>(nearly_zero<T>);
    const T inverse = T(1) / select(tiny, T(1), n);
    const T c = select(tiny, T(1), x * inverse), s = select(tiny, T(0), y * inverse);
    for (int k = 0; k < 3; ++k) {
        const T bp = b(p, k), bq = b(q, k);
        b(p, k) = c * bp + s * bq;
        b(q, k) = c * bq - s * bp;
        const T up = u(k, p), uq = u(k, q);
        u(k, p) = c * up + s * uq;
        u(k, q) = c * uq - s * up;
    }
}

}  // namespace detail

/// f: finite, entries below 1e70 in magnitude (F^T F must not overflow).
template <class T>
Svd3<T> svd3(const M3<T>& f) {
    Svd3<T> d{M3<T>::identity(), M3<T>::identity(), {}};
    M3<T> a = mul_at(f, f);
    for (int sweep = 0; sweep < 5; ++sweep) {
        detail::jacobi<0, 1>(a, d.v);
        detail::jacobi<0, 2>(a, d.v);
        detail::jacobi<1, 2>(a, d.v);
    }
    M3<T> b = mul(f, d.v);
    std::array<T, 3> norm;
    for (int j = 0; j < 3; ++j) norm[static_cast<std::size_t>(j)] = b(0, j) * b(0, j) + b(1, j) * b(1, j) + b(2, j) * b(2, j);
    detail::order_columns<0, 1>(norm, b, d.v);
    detail::order_columns<0, 2>(norm, b, d.v);
    detail::order_columns<1, 2>(norm, b, d.v);
    detail::givens<0, 1>(b, d.u);
    detail::givens<0, 2>(b, d.u);
    detail::givens<1, 2>(b, d.u);
    d.s = {b(0, 0), b(1, 1), b(2, 2)};
    return d;
}

}  // namespace tetfront
