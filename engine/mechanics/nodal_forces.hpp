#pragma once
// From stress to the nodes of a tet: what the kernels in double and in single precision have in common.
//
//     add_corner_forces<Order>(q, corner, nodal);      // for each quadrature point
//     store_nodal(nodal, out);

#include <array>

#include <immintrin.h>

#include "engine/base/voigt.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

/// Effective corners that the position of node i enters, with dN_i / dlambda_k: one for a corner, two for a midpoint.
template <int Order>
struct Contributions {
    struct Term {
        int corner;
        double weight;
    };
    std::array<std::array<std::array<Term, 2>, ElementOrder<Order>::nodes>, ElementOrder<Order>::points> terms{};
    std::array<int, ElementOrder<Order>::nodes> count{};

    constexpr Contributions() {
        for (int i = 0; i < ElementOrder<Order>::nodes; ++i) {
            for (int q = 0; q < ElementOrder<Order>::points; ++q) {
                int n = 0;
                for (int k = 0; k < 4; ++k) {
                    const double w = shape_derivative<Order>(q, k, i);
                    if (w != 0) terms[static_cast<std::size_t>(q)][static_cast<std::size_t>(i)][static_cast<std::size_t>(n++)] = {k, w};
                }
                count[static_cast<std::size_t>(i)] = n;
            }
        }
    }
};
template <int Order>
inline constexpr Contributions<Order> contributions{};

/// Forces on the effective corners at point q, `corner` those on 1..3 as columns, moved to the nodes. They sum to zero.
template <int Order>
void add_corner_forces(int q, const M3<Pack>& corner, std::array<V3<Pack>, ElementOrder<Order>::nodes>& nodal) {
    const auto& terms = contributions<Order>.terms[static_cast<std::size_t>(q)];
    for (std::size_t a = 0; a < 3; ++a) {
        const std::array<Pack, 4> force = {-(corner.m[3 * a] + corner.m[3 * a + 1] + corner.m[3 * a + 2]), corner.m[3 * a], corner.m[3 * a + 1],
                                           corner.m[3 * a + 2]};
        for (std::size_t i = 0; i < nodal.size(); ++i) {
            for (int n = 0; n < contributions<Order>.count[i]; ++n) {
                const auto& term = terms[i][static_cast<std::size_t>(n)];
                nodal[i][a] += Pack(term.weight) * force[static_cast<std::size_t>(term.corner)];
            }
        }
    }
}

/// Voigt strain rate in the material frame, from F's frame and its rate.
template <class T>
V6<T> strain_rate(const M3<T>& frame, const M3<T>& f_rate) {
    const M3<T> rate = mul_at(frame, f_rate);
    V6<T> result;
    for (std::size_t m = 0; m < 6; ++m) {
        const auto [i, j] = voigt_pairs[m];
        result[m] = m < 3 ? rate(i, i) : rate(i, j) + rate(j, i);
    }
    return result;
}

/// Of a nodal result in memory: x, y, z and a zero, so that one load reads it.
inline constexpr std::size_t nodal_stride = 4;

/// out: [node][lane][nodal_stride]
template <std::size_t Nodes>
void store_nodal(const std::array<V3<Pack>, Nodes>& nodal, double* out) {
    for (const V3<Pack>& f : nodal) {
        if constexpr (pack_size == 4) {
            const auto x = static_cast<__m256d>(f[0]), y = static_cast<__m256d>(f[1]), z = static_cast<__m256d>(f[2]);
            const __m256d xy_even = _mm256_unpacklo_pd(x, y), xy_odd = _mm256_unpackhi_pd(x, y);
            const __m256d z_even = _mm256_unpacklo_pd(z, _mm256_setzero_pd()), z_odd = _mm256_unpackhi_pd(z, _mm256_setzero_pd());
            _mm256_storeu_pd(out, _mm256_permute2f128_pd(xy_even, z_even, 0x20));
            _mm256_storeu_pd(out + 4, _mm256_permute2f128_pd(xy_odd, z_odd, 0x20));
            _mm256_storeu_pd(out + 8, _mm256_permute2f128_pd(xy_even, z_even, 0x31));
            _mm256_storeu_pd(out + 12, _mm256_permute2f128_pd(xy_odd, z_odd, 0x31));
        } else {
            for (std::size_t lane = 0; lane < pack_size; ++lane)
                for (std::size_t a = 0; a < nodal_stride; ++a) out[lane * nodal_stride + a] = a < 3 ? static_cast<double>(f[a][lane]) : 0;
        }
        out += pack_size * nodal_stride;
    }
}

}  // namespace tetfront
