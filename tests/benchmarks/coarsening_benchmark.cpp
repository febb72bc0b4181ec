// Throughput of the elasticity matrices: parents a second and core, linear and with nonlinear sampling.
//   build/release/tests/coarsening_benchmark

#include "engine/mechanics/cell_sampling.hpp"
#include "engine/mechanics/elasticity.hpp"

#include <random>

#include <benchmark/benchmark.h>

namespace {

using namespace tetfront;

const Eigen::Matrix<double, 3, 4>& gradients() {
    static const auto g = corner_gradients({Vec3(0, 0, 0), Vec3(1, 0.1, 0), Vec3(0.2, 1.1, 0.1), Vec3(0.1, 0.3, 0.8)});
    return g;
}

/// Children of random isotropic materials up to `contrast`.
std::vector<std::array<Sym6, 8>> parents(double contrast) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> exponent(0, std::log(contrast));
    std::vector<std::array<Sym6, 8>> list(64);
    for (auto& children : list)
        for (Sym6& c : children) c = isotropic(1e4 * std::exp(exponent(random)), 0.3);
    return list;
}

void linear(benchmark::State& state) {
    const auto list = parents(100);
    std::size_t i = 0;
    for (auto _ : state)
        benchmark::DoNotOptimize(
            solve_cell(static_cast<CellProblem>(state.range(0)), gradients(), list[i++ % list.size()]));
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(linear)->ArgName("problem")->DenseRange(0, 3);

void sampled(benchmark::State& state) {
    const auto list = parents(static_cast<double>(state.range(1)));
    std::size_t i = 0;
    double newton = 0, samples = 0;
    for (auto _ : state) {
        const SampledCell cell =
            sample_cell(static_cast<CellProblem>(state.range(0)), gradients(), list[i++ % list.size()], nullptr, {});
        newton += cell.newton_iterations;
        samples += cell.samples;
    }
    state.SetItemsProcessed(state.iterations());
    state.counters["samples"] = benchmark::Counter(samples, benchmark::Counter::kAvgIterations);
    state.counters["newton"] = benchmark::Counter(newton, benchmark::Counter::kAvgIterations);
}
BENCHMARK(sampled)->ArgNames({"problem", "contrast"})->ArgsProduct({{1, 2}, {2, 10, 100, 10000, 1000000}});

/// Parents in the middle of a uniform part of an object that is not uniform as a whole.
void uniform_parents(benchmark::State& state) {
    const TetTree tree(box_mesh({0, 0, 0}, {2, 1, 1}, {8, 4, 4}), 2);
    const StiffnessFunction f(layers(0, {1}), {{.young = constant(1e4)}, {.young = constant(1e6)}});
    const LeafMaterials leaves = integrate_leaves(tree, f);
    EstimationSettings settings;
    settings.sampling.emplace();
    for (auto _ : state) benchmark::DoNotOptimize(estimate_elasticity(tree, leaves, settings));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(tree.tet_count() - tree.tet_count(2)));
}
BENCHMARK(uniform_parents)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
