#pragma once
// Parallel loops whose result does not depend on the number of threads.
//
// The range is cut in chunks of a fixed size; a loop body writes only what its own index owns, and a sum adds the
// chunks' partial sums in order. So the same input gives the same bits with 1, 2 and 8 threads.
//
//     parallel_for(n, 256, [&](std::size_t begin, std::size_t end) { for (i = begin; i < end; ++i) y[i] = f(x[i]); });
//     double norm2 = parallel_sum(n, 4096, [&](std::size_t begin, std::size_t end) { double s = 0; ...; return s; });

#include <algorithm>
#include <cstddef>
#include <vector>

#if defined(__SANITIZE_THREAD__)
#include <exception>
#include <thread>
#else
#include <tbb/parallel_for.h>
#endif

namespace tetfront {

namespace detail {

/// run(chunk) for each of [0, chunks), on several threads; has ended when it returns. Throws what a run has thrown.
template <class Run>
void for_each_chunk(std::size_t chunks, const Run& run) {
#if defined(__SANITIZE_THREAD__)
    // The thread sanitizer cannot see how oneTBB's library, which is not built with it, hands work from thread to thread. Two
    // plain threads a loop are slow, but it sees the fork and the join, and so each race between the halves.
    std::exception_ptr failure;
    std::thread odd([&] {
        try {
            for (std::size_t chunk = 1; chunk < chunks; chunk += 2) run(chunk);
        } catch (...) {
            failure = std::current_exception();
        }
    });
    try {
        for (std::size_t chunk = 0; chunk < chunks; chunk += 2) run(chunk);
    } catch (...) {
        odd.join();
        throw;
    }
    odd.join();
    if (failure) std::rethrow_exception(failure);
#else
    tbb::parallel_for(std::size_t{0}, chunks, run);
#endif
}

}  // namespace detail

/// body(begin, end) for consecutive chunks of at most `grain` indices that cover [0, count).
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
    const std::size_t chunks = (count + grain - 1) / grain;
    if (chunks <= 1) {
        if (count) body(std::size_t{0}, count);
        return;
    }
    detail::for_each_chunk(chunks, [&](std::size_t chunk) {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
    });
}

/// Sum of body(begin, end) over the chunks, added in order.
template <class Body>
double parallel_sum(std::size_t count, std::size_t grain, const Body& body) {
    const std::size_t chunks = (count + grain - 1) / grain;
    if (chunks <= 1) return count ? body(std::size_t{0}, count) : 0.0;
    thread_local std::vector<double> partial;
    std::vector<double>& sums = partial;
    sums.assign(chunks, 0.0);
    double* out = sums.data();
    detail::for_each_chunk(chunks, [&, out](std::size_t chunk) {
        out[chunk] = body(chunk * grain, std::min(count, (chunk + 1) * grain));
    });
    double total = 0;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) total += out[chunk];
    return total;
}

}  // namespace tetfront
