#pragma once
// From stress to the nodes of a tet: what the kernels in double and in single precision have in common.
//
//     add_corner_forces<Order>(q, corner, nodal);      // for each quadrature point
//     store_nodal(nodal, out);

#include <array>
#include <type_traits>
#include <utility>

#include <immintrin.h>

#include "engine/base/voigt.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace detail {
/// sum_k dN_I / dlambda_k force_k at point Q, without the terms that are zero. Worked out by the compiler: as loops over a
/// table it was a seventh of the time of a linear tet.
template <int Order, int Q, int I, std::size_t... K>
Pack node_force(const std::array<Pack, 4>& force, std::index_sequence<K...>) {
    Pack sum(0);
    const auto add = [&]<int k>(std::integral_constant<int, k>) {
        constexpr double weight = shape_derivative<Order>(Q, k, I);
        if constexpr (weight != 0) sum += Pack(weight) * force[static_cast<std::size_t>(k)];
    };
    (add(std::integral_constant<int, static_cast<int>(K)>{}), ...);
    return sum;
}
template <int Order, int Q, std::size_t... I>
void add_corner_forces_at(const M3<Pack>& corner, std::array<V3<Pack>, ElementOrder<Order>::nodes>& nodal, std::index_sequence<I...>) {
    for (std::size_t a = 0; a < 3; ++a) {
        const Pack* f = &corner.m[3 * a];
        const std::array<Pack, 4> force = {-(f[0] + f[1] + f[2]), f[0], f[1], f[2]};
        ((nodal[I][a] += node_force<Order, Q, static_cast<int>(I)>(force, std::make_index_sequence<4>{})), ...);
    }
}
}  // namespace detail

/// Forces on the effective corners at point q, `corner` those on 1..3 as columns, moved to the nodes. They sum to zero.
template <int Order>
void add_corner_forces(int q, const M3<Pack>& corner, std::array<V3<Pack>, ElementOrder<Order>::nodes>& nodal) {
    constexpr std::make_index_sequence<ElementOrder<Order>::nodes> nodes{};
    if constexpr (Order == 1) {
        detail::add_corner_forces_at<1, 0>(corner, nodal, nodes);
    } else {
        switch (q) {
            case 0: return detail::add_corner_forces_at<2, 0>(corner, nodal, nodes);
            case 1: return detail::add_corner_forces_at<2, 1>(corner, nodal, nodes);
            case 2: return detail::add_corner_forces_at<2, 2>(corner, nodal, nodes);
            default: return detail::add_corner_forces_at<2, 3>(corner, nodal, nodes);
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
