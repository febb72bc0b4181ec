// Times element kernels, the scalar loop and whole steps with Google Benchmark.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <benchmark/benchmark.h>

#include "engine/base/parallel.hpp"
#include "engine/base/thread_limit.hpp"
#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/gather.hpp"
#include "engine/mechanics/strain.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/cli/bench.hpp"
#include "server/cli/bench_counting.hpp"
#include "tests/benchmarks/scalar_explicit.hpp"

namespace tetfront {

namespace {

constexpr double frame_seconds = 1.0 / 60;

Scene beam(const std::array<int, 3>& cells, int levels, int order, const ScalarSpec& young) {
    Scene scene;
    scene.name = "bench";
    scene.mesh = BoxMeshSpec{{0, 0, 0}, {4, 1, 1}, cells};
    scene.levels = levels;
    scene.material.materials[0].young = young;
    scene.pins = {Box{{-1, -1, -1}, {1e-6, 2, 2}}};
    scene.front.order = order;
    scene.front.min_level = scene.front.max_level = levels - (order - 1);
    scene.solver.cg_tolerance = 1e-6;
    return scene;
}

/// A uniform front, slightly deformed, with all that its kernels need.
struct Body {
    explicit Body(const Scene& scene)
        : model(build_model(scene)),
          front(model->tree, scene.front.order, scene.front.min_level, scene.front.max_level),
          x(model->tree.rest()) {
        for (VertexId v : front.vertices()) x[v] += 0.02 * Vec3(std::sin(x[v][1]), std::sin(x[v][2] + x[v][0]), std::cos(x[v][0]));
        elements.build(front, {model->matrices.elasticity, model->density});
        matrix.build(front, elements, model->pinned);
        elements.evaluate({.x = x, .tangent = true, .stiffness_scale = frame_seconds * frame_seconds, .mass_scale = 1});
        matrix.fill(elements);
        p.assign(matrix.size(), Vec3(1, 2, 3));
        q.resize(matrix.size());
        for (TetId t : front.active()) {
            const auto& c = model->tree.corners(t);
            gradients.push_back(barycentric_gradients({model->tree.rest(c[0]), model->tree.rest(c[1]), model->tree.rest(c[2]), model->tree.rest(c[3])}));
            nodes.push_back(front.nodes(t));
        }
        out.resize(front.active().size() * static_cast<std::size_t>(elements.points()) * 6);
    }
    std::shared_ptr<const Model> model;
    Front front;
    PerVertex<Vec3> x;
    ElementSet elements;
    BlockMatrix matrix;
    DofVector p, q;
    std::vector<Gradients<double>> gradients;
    std::vector<std::array<VertexId, 10>> nodes;
    std::vector<double> out;

    [[nodiscard]] double per_tet(double whole) const { return whole / static_cast<double>(front.active().size()); }
};

/// Strains alone, from positions to Voigt vectors.
template <int Order, template <class> class Strain>
void strains(Body& body) {
    using O = ElementOrder<Order>;
    parallel_for(body.nodes.size() / pack_size, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            std::int32_t node[O::nodes][pack_size];
            Gradients<Pack> g;
            for (std::size_t i = 0; i < O::nodes; ++i)
                for (std::size_t l = 0; l < pack_size; ++l) node[i][l] = body.nodes[b * pack_size + l][i].value;
            for (std::size_t m = 0; m < 9; ++m) g.m[m] = Pack([&](auto l) { return body.gradients[b * pack_size + l].m[m]; });
            const auto x = gather<O::nodes>(body.x, node);
            for (int point = 0; point < O::points; ++point) {
                const auto e = Strain<Pack>(deformation_gradient<Order>(x, point, g)).strain();
                for (std::size_t m = 0; m < 6; ++m)
                    store(e[m], &body.out[((b * O::points + static_cast<std::size_t>(point)) * 6 + m) * pack_size]);
            }
        }
    });
}

class Collector : public benchmark::BenchmarkReporter {
 public:
    explicit Collector(std::vector<BenchRow>& planned) : planned_(planned) {}
    bool ReportContext(const Context&) override { return true; }
    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
            BenchRow& row = planned_[static_cast<std::size_t>(run.counters.at("row").value)];
            const double seconds = run.real_accumulated_time / static_cast<double>(run.iterations);
            if (row.seconds == 0 || seconds < row.seconds) row.seconds = seconds;
            const auto iterations = run.counters.find("iterations");
            if (iterations != run.counters.end()) row.iterations = iterations->second.value;
            const auto substeps = run.counters.find("substeps");
            if (substeps != run.counters.end()) row.substeps = substeps->second.value;
            std::fprintf(stderr, "%-50s %10.1f ns/tet\n", run.benchmark_name().c_str(), row.ns_per_tet());
        }
    }

 private:
    std::vector<BenchRow>& planned_;
};

/// What one step took.
struct Counts {
    Counts(int iterations_, int substeps_ = 0) : iterations(iterations_), substeps(substeps_) {}
    int iterations, substeps;
};

/// Registers measurements; the rows get their times when they run.
class Plan {
 public:
    explicit Plan(const BenchOptions& options) : options_(options) {}

    /// work(): once over the whole front; returns what it took.
    template <class Work>
    void add(BenchRow row, Work work, int fixed_iterations = 0) {
        const std::string name = row.group + "/" + row.detail + "/order:" + std::to_string(row.order) + "/tets:" +
                                 std::to_string(row.tets) + "/threads:" + std::to_string(row.threads);
        const std::size_t number = rows.size();
        const int threads = row.threads;
        rows.push_back(std::move(row));
        auto* b = benchmark::RegisterBenchmark(name.c_str(), [work, number, threads](benchmark::State& state) {
            const ThreadLimit limit(threads);
            work();  // caches, threads, the solver's first guess
            double iterations = 0, substeps = 0;
            for (auto _ : state) {
                const Counts counts = work();
                iterations += counts.iterations;
                substeps += counts.substeps;
            }
            state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
            state.counters["substeps"] = substeps / static_cast<double>(state.iterations());
            state.counters["row"] = static_cast<double>(number);
        });
        b->UseRealTime()->Repetitions(options_.quick ? 1 : 5);
        if (fixed_iterations > 0) {
            b->Iterations(fixed_iterations);
        } else {
            b->MinTime(options_.quick ? 0.02 : 0.2);
        }
    }
    std::vector<BenchRow> rows;

 private:
    const BenchOptions& options_;
};

template <int Order>
void plan_kernels(Plan& plan, bool quick) {
    using O = ElementOrder<Order>;
    const auto body = std::make_shared<Body>(beam({8, 2, 2}, quick ? 1 : Order + 1, Order, 1e5));
    const std::size_t tets = body->front.active().size();
    const double vertices = body->per_tet(static_cast<double>(body->front.vertices().size()));
    const double read = O::nodes * 4 + 9 * 8 + vertices * 24;  // node numbers, gradients, positions once
    const double strain_bytes = O::points * 6 * 8;
    const double force_bytes = read + 4 * 8 + O::nodes * 24 + strain_bytes + 16;
    const double blocks = O::nodes * (O::nodes + 1) / 2;
    for (int threads : {1, 2}) {
        const BenchRow row{.group = "", .detail = "", .order = Order, .threads = threads, .tets = tets};
        const auto add = [&](const char* group, const char* detail, double bytes, double flops, auto work) {
            BenchRow r = row;
            r.group = group;
            r.detail = detail;
            r.bytes = bytes;
            r.flops = flops;
            plan.add(std::move(r), [body, work] {
                work(*body);
                return 0;
            });
        };
        add("strain", "green", read + strain_bytes, strain_flops<Order, GreenPoint>(), strains<Order, GreenPoint>);
        add("strain", "corotated", read + strain_bytes, strain_flops<Order, CorotatedPoint>(), strains<Order, CorotatedPoint>);
        for (const bool green : {true, false}) {
            const double flops = green ? force_flops<Order, GreenPoint>() : force_flops<Order, CorotatedPoint>();
            const auto measure = green ? StrainMeasure::green : StrainMeasure::corotated;
            const char* name = green ? "green" : "corotated";
            add("force", name, force_bytes, flops, [measure](Body& b) {
                b.elements.set_strain_measure(measure);
                b.elements.evaluate({.x = b.x});
            });
            // As explicit steps call it: without strains.
            add("force_single", name, O::nodes * 4 + 9 * 4 + vertices * 24 + 3 * 4 + O::nodes * 24 + 8, flops, [measure](Body& b) {
                b.elements.set_strain_measure(measure);
                b.elements.evaluate({.x = b.x, .single = true});
            });
            add("tangent", name, force_bytes + blocks * 36, flops + tangent_flops<Order>(), [measure](Body& b) {
                b.elements.set_strain_measure(measure);
                b.elements.evaluate({.x = b.x, .tangent = true, .stiffness_scale = frame_seconds * frame_seconds, .mass_scale = 1});
            });
        }
        const double stored = body->per_tet(static_cast<double>(body->matrix.block_count()));
        const double unknowns = body->per_tet(static_cast<double>(body->matrix.size()));
        add("matvec", "block", stored * 40 + unknowns * 52, stored * 18, [](Body& b) { b.matrix.multiply(b.p, b.q); });
    }
}

/// A uniform front with its simulation and, for one stiffness, its yardstick. Only the last one that was asked for is kept: the largest take
/// a gigabyte.
class StepFront {
 public:
    StepFront(const std::array<int, 3>& cells, int levels, ScalarSpec young) : cells_(cells), levels_(levels), young_(std::move(young)) {}

    [[nodiscard]] std::size_t tets() const {
        return static_cast<std::size_t>(6 * cells_[0] * cells_[1] * cells_[2]) << (3 * levels_);
    }
    Simulation& simulation() { return *made().simulation; }
    /// Chooses between implicit and explicit steps by itself; Green strain, as the loop.
    Simulation& automatic() { return *made().automatic; }
    /// For one stiffness everywhere only.
    ScalarExplicit& loop() { return *made().loop; }

 private:
    struct Made {
        const StepFront* by = nullptr;
        std::unique_ptr<Simulation> simulation, automatic;
        std::unique_ptr<ScalarExplicit> loop;
    };
    Made& made() const {
        static Made last;
        if (last.by == this) return last;
        last = {};
        const auto model = build_model(beam(cells_, levels_, 1, young_));
        if (const double* young = std::get_if<double>(&young_)) last.loop = make_loop(*model, *young);
        last.simulation = std::make_unique<Simulation>(model);
        Scene scene = beam(cells_, levels_, 1, young_);
        scene.solver.scheme = Scheme::automatic;
        scene.solver.strain = StrainMeasure::green;
        last.automatic = std::make_unique<Simulation>(build_model(scene));
        last.by = this;
        return last;
    }
    [[nodiscard]] std::unique_ptr<ScalarExplicit> make_loop(const Model& model, double young) const {
        std::vector<Vec3> rest(model.tree.vertex_count(levels_));
        std::vector<char> pinned(rest.size());
        for (VertexId v : ids<VertexId>(rest.size())) {
            rest[v.index()] = model.tree.rest(v);
            pinned[v.index()] = static_cast<char>(model.pinned[v]);
        }
        std::vector<std::array<int, 4>> corners;
        for (TetId t : model.tree.level(levels_)) {
            const auto& c = model.tree.corners(t);
            corners.push_back({c[0].value, c[1].value, c[2].value, c[3].value});
        }
        return std::make_unique<ScalarExplicit>(std::move(rest), std::move(corners), std::move(pinned),
                                                ScalarExplicit::Material{young, 0.3, 1000});
    }
    std::array<int, 3> cells_;
    int levels_;
    ScalarSpec young_;
};

void plan_steps(Plan& plan, bool quick) {
    // About 3k, 12k, 53k and 192k tets; all have a tree, so that the preconditioner has levels.
    std::vector<std::pair<std::array<int, 3>, int>> sizes = {{{10, 2, 3}, 1}, {{8, 2, 2}, 2}, {{26, 6, 7}, 1}, {{20, 5, 5}, 2}};
    if (quick) sizes.resize(2);
    const int steps = quick ? 2 : 10;
    const auto add_steps = [&](const std::shared_ptr<StepFront>& front, const std::string& detail) {
        for (int threads : {1, 2}) {
            plan.add({.group = "step", .detail = detail, .order = 1, .threads = threads, .tets = front->tets()},
                     [front] { return front->simulation().step().solver_iterations; }, steps);
        }
        plan.add({.group = "auto", .detail = detail, .order = 1, .threads = 1, .tets = front->tets()}, [front] {
            const StepReport r = front->automatic().step();
            return Counts{r.solver_iterations, r.substeps};
        }, steps);
    };
    for (const auto& [cells, levels] : sizes) {
        for (double young : {1e5, 1e6, 1e7}) {
            const auto front = std::make_shared<StepFront>(cells, levels, young);
            char detail[32];
            std::snprintf(detail, sizeof detail, "E %.0e", young);
            add_steps(front, detail);
            plan.add({.group = "scalar_frame", .detail = detail, .order = 1, .threads = 1, .tets = front->tets()},
                     [front] {
                         front->loop().frame(frame_seconds);
                         return Counts{0, front->loop().substeps(frame_seconds)};
                     },
                     steps);
            if (young > 1e5) continue;
            plan.add({.group = "scalar_force", .detail = "green", .order = 1, .threads = 1, .tets = front->tets()}, [front] {
                front->loop().forces();
                return 0;
            });
        }
    }
    const auto& [cells, levels] = sizes.back();
    const GradientSpec contrast{.axis = 0, .at = {}, .values = {1e4, 1e6}, .interpolation = Interpolation::exponential};
    add_steps(std::make_shared<StepFront>(cells, levels, contrast), "E 1e4..1e6");
}

}  // namespace

double BenchRow::fraction(const MachineLimits& limits) const {
    if (seconds == 0) return 0;
    const double n = static_cast<double>(tets);
    const double most_flops = group == "force_single" ? 2 * limits.fma_flops : limits.fma_flops;  // twice the lanes
    return std::max(bytes * n / limits.triad_bytes, flops * n / most_flops) / seconds;
}

BenchResults run_bench(const BenchOptions& options) {
    BenchResults results;
    Plan plan(options);
    plan_kernels<1>(plan, options.quick);
    plan_kernels<2>(plan, options.quick);
    plan_steps(plan, options.quick);
    for (int threads : {1, 2}) results.limits.push_back(measure_limits(threads, options.quick));
    Collector collector(plan.rows);
    benchmark::RunSpecifiedBenchmarks(&collector, options.filter.empty() ? "." : options.filter);
    benchmark::Shutdown();
    results.rows = std::move(plan.rows);
    std::erase_if(results.rows, [](const BenchRow& r) { return r.seconds == 0; });
    if (options.filter.empty()) results.iterations = count_iterations(options.quick);
    return results;
}

}  // namespace tetfront
