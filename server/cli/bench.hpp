#pragma once
// What `tetfront bench` measures: limits of the machine, element kernels, whole steps and iterations of the solver.
//
// Google Benchmark repeats each measurement until it is long enough; the least time of the repetitions counts, because on
// a shared machine everything else is somebody else's. Bytes and operations are counted, not measured: bytes from the
// arrays that a kernel reads and writes, operations by running the same kernels on a scalar that counts.
//
//     BenchResults results = run_bench({.quick = true});
//     write_bench_report(out, results, "tetfront bench --report");

#include <iosfwd>
#include <string>
#include <vector>

namespace tetfront {

struct BenchOptions {
    bool quick = false;      // short repetitions and small fronts: to try it
    std::string filter;      // regular expression that names must contain; empty: all
};

struct MachineLimits {
    int threads = 1;
    double triad_bytes = 0;  // [bytes/s] a = b + s c over three arrays of 64 MB
    double fma_flops = 0;    // [1/s] double multiply-adds count two
};

/// One measurement.
struct BenchRow {
    std::string group;   // strain, force, force_single, tangent, matvec, step, auto, scalar_force, scalar_frame
    std::string detail;  // e.g. green, corotated, E 1e5
    int order = 1, threads = 1;
    std::size_t tets = 0;
    double seconds = 0;            // once over the whole front
    double bytes = 0, flops = 0;   // per tet; 0: not counted
    double iterations = 0;         // of the solver, a step
    double substeps = 0;           // explicit ones, a step

    [[nodiscard]] double ns_per_tet() const { return seconds * 1e9 / static_cast<double>(tets); }
    /// Of the limit that binds: the longer of the times that bytes and operations need at best over the time measured.
    [[nodiscard]] double fraction(const MachineLimits& limits) const;
};

struct IterationRow {
    int order = 1, level = 0;
    bool hanging = false;
    std::size_t tets = 0, unknowns = 0;
    int jacobi = 0, multilevel = 0;
};

struct BenchResults {
    std::vector<MachineLimits> limits;  // for 1 and 2 threads
    std::vector<BenchRow> rows;
    std::vector<IterationRow> iterations;
};

MachineLimits measure_limits(int threads, bool quick);
std::vector<IterationRow> count_iterations(bool quick);
/// Progress goes to standard error.
BenchResults run_bench(const BenchOptions& options);

std::string bench_json(const BenchResults& results);
void write_bench_report(std::ostream& out, const BenchResults& results, const std::string& command);

}  // namespace tetfront
