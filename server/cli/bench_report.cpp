// The results of `tetfront bench` as JSON and as the report tests/reports/speed.md.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <ostream>
#include <thread>

#include <nlohmann/json.hpp>

#include "server/cli/bench.hpp"

namespace tetfront {

namespace {

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown CPU";
}

std::string number(double value, const char* format = "%.3g") {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

const BenchRow* find(const BenchResults& results, const std::string& group, const std::string& detail, int order, int threads, std::size_t tets) {
    for (const BenchRow& r : results.rows) {
        if (r.group == group && r.detail == detail && r.order == order && r.threads == threads && (tets == 0 || r.tets == tets)) return &r;
    }
    return nullptr;
}

/// One line of the table of targets; nothing when one of the two has not been measured.
void target(std::ostream& out, const std::string& what, const BenchRow* slow, const BenchRow* fast, double goal) {
    if (slow == nullptr || fast == nullptr) return;
    const double ratio = slow->ns_per_tet() / fast->ns_per_tet();
    out << "| " << what << " | " << number(goal) << " | " << number(ratio) << " | " << (ratio >= goal ? "yes" : "missed") << " |\n";
}

void write_targets(std::ostream& out, const BenchResults& results) {
    out << "\n## Targets\n\nRatios of times in this run; more is better.\n\n| what | target | measured | reached |\n|---|---|---|---|\n";
    // The yardstick's front that is nearest in size to the kernels'.
    const BenchRow* force = find(results, "force", "green", 1, 1, 0);
    const BenchRow* scalar = force != nullptr ? find(results, "scalar_force", "green", 1, 1, force->tets) : nullptr;
    target(out, "scalar force over ours (Green, linear, double)", scalar, force, 3);
    target(out, "scalar force over ours (Green, linear, single precision)", scalar, find(results, "force_single", "green", 1, 1, 0), 5);
    for (const char* kernel : {"strain", "force", "force_single", "tangent"}) {
        for (int order : {1, 2}) {
            target(out, std::string("second thread, ") + kernel + ", order " + std::to_string(order), find(results, kernel, "corotated", order, 1, 0),
                   find(results, kernel, "corotated", order, 2, 0), 1.7);
        }
    }
    for (int order : {1, 2})
        target(out, "second thread, matvec, order " + std::to_string(order), find(results, "matvec", "block", order, 1, 0),
               find(results, "matvec", "block", order, 2, 0), 1.7);
    for (const BenchRow& r : results.rows) {
        if (r.group != "auto") continue;
        target(out, "scalar explicit frame over ours with `auto`, " + r.detail + ", " + std::to_string(r.tets) + " tets",
               find(results, "scalar_frame", r.detail, 1, 1, r.tets), &r, 1);
    }
    out << "\nThe fastest other engine is implicit; its times are from another machine of this kind, so these ratios are no better than that.\n\n"
           "| one thread, steps of 1/60 s, CG to 1e-6 | the fastest other engine | here, implicit | times faster | here, `auto` | times faster (target 4) |\n"
           "|---|---|---|---|---|---|\n";
    // Other engines' fronts have 12,288, 52,728 and 192,000 tets; ours of 52,416 is the nearest that has a tree.
    struct Guide {
        const char* detail;
        std::size_t tets;
        double milliseconds;
    };
    for (const Guide& guide : {Guide{"E 1e+05", 12288, 10.8}, {"E 1e+05", 52416, 64}, {"E 1e+05", 192000, 278}, {"E 1e4..1e6", 192000, 518}}) {
        const BenchRow* implicit = find(results, "step", guide.detail, 1, 1, guide.tets);
        const BenchRow* automatic = find(results, "auto", guide.detail, 1, 1, guide.tets);
        if (implicit == nullptr || automatic == nullptr) continue;
        const auto times = [&](const BenchRow* r) { return guide.milliseconds * 1e-3 / r->seconds; };
        out << "| " << guide.tets << " tets, " << guide.detail << " | " << guide.milliseconds << " ms | " << number(1e3 * implicit->seconds) << " ms | "
            << number(times(implicit)) << " | " << number(1e3 * automatic->seconds) << " ms | " << number(times(automatic))
            << (times(automatic) >= 4 ? "" : " (missed)") << " |\n";
    }
}

}  // namespace

std::string bench_json(const BenchResults& results) {
    nlohmann::json j;
    for (const MachineLimits& l : results.limits)
        j["limits"].push_back({{"threads", l.threads}, {"triad_bytes_per_second", l.triad_bytes}, {"fma_flops_per_second", l.fma_flops}});
    for (const BenchRow& r : results.rows) {
        j["measurements"].push_back({{"group", r.group}, {"detail", r.detail}, {"order", r.order}, {"threads", r.threads}, {"tets", r.tets},
                                     {"seconds", r.seconds}, {"nanoseconds_per_tet", r.ns_per_tet()}, {"bytes_per_tet", r.bytes},
                                     {"flops_per_tet", r.flops}, {"iterations", r.iterations}, {"substeps", r.substeps},
                                     {"fraction_of_limit", r.fraction(results.limits[static_cast<std::size_t>(r.threads - 1)])}});
    }
    for (const IterationRow& r : results.iterations) {
        j["iterations"].push_back({{"order", r.order}, {"level", r.level}, {"hanging", r.hanging}, {"tets", r.tets}, {"unknowns", r.unknowns},
                                   {"block_jacobi", r.jacobi}, {"multilevel", r.multilevel}});
    }
    return j.dump(2) + "\n";
}

void write_bench_report(std::ostream& out, const BenchResults& results, const std::string& command) {
    const std::time_t now = std::time(nullptr);
    char date[32];
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    out << "# Speed\n\nMade by `" << command << "` on " << date << ", " << cpu_name() << ", " << std::thread::hardware_concurrency()
        << " threads. Do not edit: run the command again.\n\nThe box 4 x 1 x 1 m, clamped at one end, nu 0.3, 1000 kg/m3, uniform fronts. The "
           "scalar loop is tests/benchmarks/scalar_explicit.cpp.\n\nLimits of the machine in this run:\n\n| threads | triad GB/s | multiply-add "
           "GFLOP/s |\n|---|---|---|\n";
    for (const MachineLimits& l : results.limits)
        out << "| " << l.threads << " | " << number(l.triad_bytes * 1e-9) << " | " << number(l.fma_flops * 1e-9) << " |\n";
    write_targets(out, results);
    out << "\n## Kernels\n\nBytes and operations are counted. `of limit`: the time that the binding one of both needs at best over the time "
           "measured.\nFronts that fit the cache can exceed 100 % of the memory's.\n\n"
           "| kernel | strain | order | tets | threads | ns per tet | bytes | flops | of limit |\n|---|---|---|---|---|---|---|---|---|\n";
    for (const BenchRow& r : results.rows) {
        if (r.bytes == 0 && r.group != "scalar_force") continue;
        out << "| " << r.group << " | " << r.detail << " | " << r.order << " | " << r.tets << " | " << r.threads << " | " << number(r.ns_per_tet())
            << " | " << number(r.bytes, "%.0f") << " | " << number(r.flops, "%.0f") << " | "
            << number(100 * r.fraction(results.limits[static_cast<std::size_t>(r.threads - 1)]), "%.0f") << " % |\n";
    }
    out << "\n## Whole steps of 1/60 s\n\nImplicit (one linearised step, CG to 1e-6, error indicators included), steps that choose by themselves, and "
           "frames of the scalar explicit loop.\n\n| what | E | tets | threads | ms | CG iterations | substeps |\n|---|---|---|---|---|---|---|\n";
    for (const BenchRow& r : results.rows) {
        if (r.group != "step" && r.group != "auto" && r.group != "scalar_frame") continue;
        out << "| " << (r.group == "step" ? "implicit" : r.group == "auto" ? "`auto`" : "scalar explicit") << " | " << r.detail.substr(2) << " | " << r.tets << " | " << r.threads
            << " | " << number(1e3 * r.seconds) << " | " << number(r.iterations, "%.0f") << " | " << number(r.substeps, "%.0f") << " |\n";
    }
    if (results.iterations.empty()) return;
    out << "\n## CG iterations to 1e-6\n\nFirst step of the fall, E 5e6. Hanging: the front one level finer where x < 1 m.\n\n"
           "| order | level | hanging | tets | unknowns | block-Jacobi | multilevel |\n|---|---|---|---|---|---|---|\n";
    for (const IterationRow& r : results.iterations)
        out << "| " << r.order << " | " << r.level << " | " << (r.hanging ? "yes" : "no") << " | " << r.tets << " | " << r.unknowns << " | "
            << r.jacobi << " | " << r.multilevel << " |\n";
}

}  // namespace tetfront
