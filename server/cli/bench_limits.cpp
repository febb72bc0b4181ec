// What the machine can do at most: memory triad and multiply-adds, measured in the same run as everything else.
#include "server/cli/bench.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#include <immintrin.h>

namespace tetfront {

namespace {

double seconds_of(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Calls work(thread) in `threads` threads.
void in_threads(int threads, const auto& work) {
    std::vector<std::jthread> others;
    for (int t = 1; t < threads; ++t) others.emplace_back([&work, t] { work(t); });
    work(0);
}

/// Ten independent chains hide the latency of the multiply-add.
double multiply_add_chains(std::size_t rounds) {
    __m256d sum[10];
    for (int i = 0; i < 10; ++i) sum[i] = _mm256_set1_pd(1 + 0.1 * i);
    const __m256d a = _mm256_set1_pd(0.999999), b = _mm256_set1_pd(1e-7);
    for (std::size_t r = 0; r < rounds; ++r)
        for (__m256d& s : sum) s = _mm256_fmadd_pd(s, a, b);
    __m256d total = sum[0];
    for (int i = 1; i < 10; ++i) total = _mm256_add_pd(total, sum[i]);
    return total[0] + total[1] + total[2] + total[3];
}

}  // namespace

MachineLimits measure_limits(int threads, bool quick) {
    MachineLimits limits;
    limits.threads = threads;
    const std::size_t n = (quick ? std::size_t{1} : std::size_t{8}) << 20;
    std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
    const std::size_t part = n / static_cast<std::size_t>(threads);
    double triad = 1e300, fma = 1e300;
    const std::size_t rounds = quick ? 1'000'000 : 10'000'000;
    for (int repeat = 0; repeat < (quick ? 3 : 10); ++repeat) {
        triad = std::min(triad, seconds_of([&] {
            in_threads(threads, [&](int t) {
                double *to = a.data() + static_cast<std::size_t>(t) * part, *x = b.data() + static_cast<std::size_t>(t) * part;
                const double* y = c.data() + static_cast<std::size_t>(t) * part;
                for (std::size_t i = 0; i < part; ++i) to[i] = x[i] + 3.0 * y[i];
            });
        }));
        std::vector<double> sink(static_cast<std::size_t>(threads));
        fma = std::min(fma, seconds_of([&] {
            in_threads(threads, [&](int t) { sink[static_cast<std::size_t>(t)] = multiply_add_chains(rounds); });
        }));
        volatile double used = sink[0];
        (void)used;
    }
    limits.triad_bytes = static_cast<double>(part * static_cast<std::size_t>(threads) * 3 * sizeof(double)) / triad;
    limits.fma_flops = static_cast<double>(rounds) * 10 * 4 * 2 * threads / fma;
    return limits;
}

}  // namespace tetfront
