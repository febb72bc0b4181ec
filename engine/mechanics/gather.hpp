#pragma once
// Moves values between arrays of vertices or elements and packs of tets.
//
//     const auto x = gather<10>(positions, batch.node);      // x[i][c]: component c of node i of each lane's tet
//     scatter_blocks(block, out, stride);                    // one 3x3 block of each lane's tet, in floats

#include <array>
#include <cstdint>

#include <immintrin.h>

#include "engine/base/simd.hpp"
#include "engine/base/types.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

/// The places of four vertices, component by component, by loading and transposing whole vectors: 12 single loads per node took
/// longer than the arithmetic of a linear tet.
inline V3<Pack> gather_node(const PerVertex<Vec3>& field, const std::int32_t (&node)[pack_size]) {
    if constexpr (pack_size == 4) {
        const auto read = [&](std::size_t lane) {
            const double* p = field[VertexId(node[lane])].data();
            return _mm256_set_m128d(_mm_load_sd(p + 2), _mm_loadu_pd(p));
        };
        const __m256d a = read(0), b = read(1), c = read(2), d = read(3);
        const __m256d xz_ab = _mm256_unpacklo_pd(a, b), xz_cd = _mm256_unpacklo_pd(c, d);
        const __m256d y_ab = _mm256_unpackhi_pd(a, b), y_cd = _mm256_unpackhi_pd(c, d);
        return {Pack(_mm256_permute2f128_pd(xz_ab, xz_cd, 0x20)), Pack(_mm256_permute2f128_pd(y_ab, y_cd, 0x20)),
                Pack(_mm256_permute2f128_pd(xz_ab, xz_cd, 0x31))};
    } else {
        V3<Pack> x;
        for (int c = 0; c < 3; ++c)
            x[static_cast<std::size_t>(c)] = Pack([&](auto lane) { return field[VertexId(node[static_cast<std::size_t>(lane)])][c]; });
        return x;
    }
}

template <int Nodes>
std::array<V3<Pack>, Nodes> gather(const PerVertex<Vec3>& field, const std::int32_t (*node)[pack_size]) {
    std::array<V3<Pack>, Nodes> x;
    for (std::size_t i = 0; i < static_cast<std::size_t>(Nodes); ++i) x[i] = gather_node(field, node[i]);
    return x;
}

/// First the lanes of `low`, then those of `high`.
inline SinglePack to_single(const Pack& low, const Pack& high) {
    if constexpr (pack_size == 4) {
        return static_cast<SinglePack>(_mm256_set_m128(_mm256_cvtpd_ps(static_cast<__m256d>(high)), _mm256_cvtpd_ps(static_cast<__m256d>(low))));
    } else {
        return SinglePack([&](std::size_t l) { return static_cast<float>(l < pack_size ? low[l] : high[l - pack_size]); });
    }
}
inline std::array<Pack, 2> to_double(const SinglePack& x) {
    if constexpr (pack_size == 4) {
        const auto lanes = static_cast<__m256>(x);
        return {Pack(_mm256_cvtps_pd(_mm256_castps256_ps128(lanes))), Pack(_mm256_cvtps_pd(_mm256_extractf128_ps(lanes, 1)))};
    } else {
        return {Pack([&](std::size_t l) { return static_cast<double>(x[l]); }), Pack([&](std::size_t l) { return static_cast<double>(x[l + pack_size]); })};
    }
}

/// The same of two batches, in single precision and relative to each tet's first node: differences of nearby places keep
/// their digits.
template <int Nodes>
std::array<V3<SinglePack>, Nodes> gather_single(const PerVertex<Vec3>& field, const std::int32_t (*low)[pack_size],
                                                const std::int32_t (*high)[pack_size]) {
    const auto a = gather<Nodes>(field, low), b = gather<Nodes>(field, high);
    std::array<V3<SinglePack>, Nodes> x;
    for (std::size_t i = 0; i < static_cast<std::size_t>(Nodes); ++i)
        for (std::size_t c = 0; c < 3; ++c) x[i][c] = to_single(a[i][c] - a[0][c], b[i][c] - b[0][c]);
    return x;
}

/// Lane l of the block goes to out + l * stride: 9 floats, column-major. Written with transposed registers where a pack has
/// four lanes: 36 single stores took half the time of a whole quadratic tangent.
template <class P>
void scatter_blocks(const M3<P>& block, float* out, std::size_t stride) {
    if constexpr (P::size() == 4) {
        __m128 f[9];
        for (std::size_t m = 0; m < 9; ++m) f[m] = _mm256_cvtpd_ps(static_cast<__m256d>(block.m[m % 3 * 3 + m / 3]));
        _MM_TRANSPOSE4_PS(f[0], f[1], f[2], f[3]);
        _MM_TRANSPOSE4_PS(f[4], f[5], f[6], f[7]);
        alignas(16) float last[4];
        _mm_store_ps(last, f[8]);
        for (std::size_t lane = 0; lane < 4; ++lane) {
            float* to = out + lane * stride;
            _mm_storeu_ps(to, f[lane]);
            _mm_storeu_ps(to + 4, f[4 + lane]);
            to[8] = last[lane];
        }
    } else {
        for (std::size_t m = 0; m < 9; ++m)
            for (std::size_t lane = 0; lane < P::size(); ++lane)
                out[lane * stride + m] = static_cast<float>(static_cast<double>(block.m[m % 3 * 3 + m / 3][lane]));
    }
}

}  // namespace tetfront
