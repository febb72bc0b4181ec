#include "server/cli/bench.hpp"

#include <cstdio>
#include <iostream>
#include <memory>
#include <sstream>

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"

namespace tetfront {

namespace {

struct Arguments {
    BenchOptions options;
    std::string json, report;
};

/// `-`: standard output.
void write_text(const std::string& path, const std::string& text) {
    if (path == "-") {
        std::cout << text;
    } else {
        write_atomically(path, text);
    }
}

void print(const BenchResults& results) {
    for (const MachineLimits& l : results.limits)
        std::printf("limits, %d threads: triad %.1f GB/s, multiply-add %.1f GFLOP/s\n", l.threads, l.triad_bytes * 1e-9, l.fma_flops * 1e-9);
    std::printf("\n%-13s %-10s %5s %8s %7s %9s %10s %8s %8s %9s %10s\n", "what", "", "order", "tets", "threads", "ns/tet", "ms", "bytes/tet",
                "flops/tet", "of limit", "iterations");
    for (const BenchRow& r : results.rows) {
        std::printf("%-13s %-10s %5d %8zu %7d %9.2f %10.3f %8.0f %8.0f %8.0f%% %10.0f\n", r.group.c_str(), r.detail.c_str(), r.order, r.tets,
                    r.threads, r.ns_per_tet(), 1e3 * r.seconds, r.bytes, r.flops,
                    100 * r.fraction(results.limits[static_cast<std::size_t>(r.threads - 1)]), r.iterations);
    }
    if (results.iterations.empty()) return;
    std::printf("\n%5s %5s %8s %8s %8s %10s %10s\n", "order", "level", "hanging", "tets", "unknowns", "Jacobi", "multilevel");
    for (const IterationRow& r : results.iterations)
        std::printf("%5d %5d %8s %8zu %8zu %10d %10d\n", r.order, r.level, r.hanging ? "yes" : "no", r.tets, r.unknowns, r.jacobi, r.multilevel);
}

int bench(const Arguments& arguments) {
    const BenchResults results = run_bench(arguments.options);
    if (results.rows.empty()) throw InputError("", "--filter", "matches nothing", "use a regular expression such as force");
    if (arguments.json != "-" && arguments.report != "-") print(results);
    if (!arguments.json.empty()) write_text(arguments.json, bench_json(results));
    if (!arguments.report.empty()) {
        std::ostringstream out;
        write_bench_report(out, results, std::string("tetfront bench --report ") + arguments.report + (arguments.options.quick ? " --quick" : ""));
        write_text(arguments.report, out.str());
    }
    return exit_ok;
}

}  // namespace

void add_bench(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("bench", "Measure kernels, steps and the solver on this machine");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("--json", arguments->json, "Also write all numbers to this file; - is standard output")->type_name("FILE");
    command->add_option("--report", arguments->report, "Also write a report with the targets; - is standard output")->type_name("FILE");
    command->add_option("--filter", arguments->options.filter, "Only what matches this regular expression, e.g. force/green")->type_name("REGEX");
    command->add_flag("--quick", arguments->options.quick, "Small fronts, short repetitions: to try it");
    command->callback([arguments, &action] { action = [arguments] { return bench(*arguments); }; });
}

}  // namespace tetfront
