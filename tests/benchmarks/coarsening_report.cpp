// Measures the elasticity matrices of coarse levels and writes tests/reports/coarsening.md with its plot
// coarsening.svg.
//   build/release/tests/coarsening_report        (about a minute)

#include "engine/mechanics/elasticity_cache.hpp"
#include "tests/support/project.hpp"
#include "tests/support/static_level.hpp"

#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <thread>

#include <sys/utsname.h>
#include <unistd.h>

namespace {

using namespace tetfront;
namespace fs = std::filesystem;

constexpr std::array problems = {CellProblem::average, CellProblem::mean_strain, CellProblem::isolated,
                                 CellProblem::uniform_stress};
constexpr std::array problem_names = {"average", "mean_strain", "isolated", "uniform_stress"};

std::string number(double value, int digits = 2) {
    std::ostringstream out;
    out << std::fixed << std::setprecision(digits) << value;
    return out.str();
}

struct NamedMaterial {
    std::string name;
    StiffnessFunction function;
};

/// Materials of a 4 x 1 x 1 beam along x.
std::vector<NamedMaterial> beam_materials() {
    const MaterialFunction soft{.young = constant(1e6)}, stiff{.young = constant(1e8)};
    const auto alternating = [&](int n) {
        std::vector<MaterialFunction> list;
        for (int i = 0; i < n; ++i) list.push_back(i % 2 ? stiff : soft);
        return list;
    };
    const auto boundaries = [](double step, int n) {
        std::vector<double> list;
        for (int i = 1; i < n; ++i) list.push_back(step * i);
        return list;
    };
    std::mt19937 random(1);
    // Random blocks of half a root's size: a label image of noise.
    auto noise = std::make_shared<VoxelImage>();
    noise->source = "noise";
    noise->size = {32, 8, 8};
    noise->data.resize(32 * 8 * 8);
    for (std::byte& b : noise->data) b = static_cast<std::byte>(random() % 2);
    noise->place(Vec3::Constant(1.0 / 16), Mat3::Identity() / 8);

    MaterialFunction fibres;
    fibres.orthotropic = Orthotropic{.young = {1e8, 1e6, 1e6}, .poisson = {0.3, 0.3, 0.3}, .shear = {4e5, 2e6, 2e6}};
    return {
        {"uniform", StiffnessFunction(MaterialFunction{.young = constant(1e7)})},
        {"gradient 1e6..1e8 along x",
         StiffnessFunction({.young = gradient(0, {0, 4}, {1e6, 1e8}, Interpolation::exponential)})},
        {"layers along the beam, 8", StiffnessFunction(layers(2, boundaries(0.125, 8)), alternating(8))},
        {"layers across the beam, 32", StiffnessFunction(layers(0, boundaries(0.125, 32)), alternating(32))},
        {"stiff core in soft flesh",
         StiffnessFunction(shapes({{Box{{-1, 0.3, 0.3}, {5, 0.7, 0.7}}, 1, 0}}, 0), {soft, stiff})},
        {"random blocks, 1/8", StiffnessFunction(labels(noise, {{0, 0}, {1, 1}}, 0), {soft, stiff})},
        {"fibres along the beam", StiffnessFunction(fibres)},
    };
}

struct Tip {
    double linear[2], quadratic[2];  // one and two levels above the leaves
};

/// Tip deflections over that of the quadratic solve one level above the leaves with the leaves' own mean (finest
/// vertices).
void cantilever(std::ostream& out, std::vector<std::pair<std::string, std::map<std::string, Tip>>>& plot) {
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {8, 2, 2}), 2);
    out << "## Static tip deflection of coarse levels\n\n"
        << "Cantilever 4 x 1 x 1 m under gravity, " << tree.tet_count(0) << " root tets, two levels ("
        << tree.tet_count(2)
        << " leaves), contrast 100, nu 0.3. Tip deflection of the level over that of the finest linear\n"
        << "level (12,288 leaf tets with their own C): 1.00 is what the fine level says. L-1, L-2: one and two levels "
           "above\n"
        << "the leaves. \"linear\" shows what linear tets add to the error; \"quadratic\" takes the tree's midpoints "
           "as nodes,\n"
        << "so its error is nearly the material's. The finest linear level is itself too stiff: with uniform material "
           "the\n"
        << "quadratic columns show by how much.\n\n"
        << "| material | method | linear L-1 | linear L-2 | quadratic L-1 | quadratic L-2 "
           "|\n|---|---|---|---|---|---|\n";
    for (const NamedMaterial& material : beam_materials()) {
        const LeafMaterials leaves = integrate_leaves(tree, material.function);
        const PerTet<double> density = coarse_density(tree, leaves);
        std::map<std::string, Tip> tips;
        double finest = 0;
        for (std::size_t p = 0; p < problems.size(); ++p) {
            const PooledPerTet<Sym6> c = estimate_elasticity(tree, leaves, problems[p]).elasticity;
            const auto tip = [&](int level, int order) {
                return tip_deflection(tree, solve_static_level(tree, level, order, c, density));
            };
            if (p == 0) finest = tip(2, 1);
            const Tip t{{tip(1, 1) / finest, tip(0, 1) / finest}, {tip(1, 2) / finest, tip(0, 2) / finest}};
            tips[problem_names[p]] = t;
            out << "| " << (p == 0 ? material.name : "") << " | `" << problem_names[p] << "` | " << number(t.linear[0])
                << " | " << number(t.linear[1]) << " | " << number(t.quadratic[0]) << " | " << number(t.quadratic[1])
                << " |\n";
        }
        plot.emplace_back(material.name, tips);
        std::cerr << material.name << " done\n";
    }
    out << "\n![Tip deflection of coarse quadratic levels over the finest](coarsening.svg)\n\n";
}

/// Grouped bars on a logarithmic axis: quadratic, one level above the leaves.
void write_plot(const fs::path& file, const std::vector<std::pair<std::string, std::map<std::string, Tip>>>& tips) {
    constexpr double width = 900, height = 420, left = 60, top = 40, bottom = 110, low = 0.05, high = 20;
    const std::array colours = {"#4477aa", "#228833", "#ee6677", "#ccbb44"};
    const double plot_height = height - top - bottom, group = (width - left - 20) / static_cast<double>(tips.size());
    const auto y = [&](double value) {
        const double s = std::log(std::clamp(value, low, high) / low) / std::log(high / low);
        return top + plot_height * (1 - s);
    };
    std::ofstream svg(file);
    svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height
        << "\" font-family=\"sans-serif\" font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        << "<text x=\"" << left
        << "\" y=\"20\" font-size=\"14\">Tip deflection over the finest level's, quadratic tets two levels above "
           "the leaves (1: exact, below: too stiff)</text>\n";
    for (const double tick : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
        svg << "<line x1=\"" << left << "\" x2=\"" << width - 20 << "\" y1=\"" << y(tick) << "\" y2=\"" << y(tick)
            << "\" stroke=\"" << (tick == 1 ? "#000" : "#ddd") << "\"/><text x=\"" << left - 8 << "\" y=\""
            << y(tick) + 4 << "\" text-anchor=\"end\">" << tick << "</text>\n";
    }
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const double x0 = left + group * (static_cast<double>(i) + 0.1), bar = group * 0.8 / problems.size();
        for (std::size_t p = 0; p < problems.size(); ++p) {
            const double value = tips[i].second.at(problem_names[p]).quadratic[1], a = y(value), b = y(1);
            svg << "<rect x=\"" << x0 + bar * static_cast<double>(p) << "\" width=\"" << bar * 0.9 << "\" y=\""
                << std::min(a, b) << "\" height=\"" << std::max(std::abs(a - b), 1.0) << "\" fill=\"" << colours[p]
                << "\"/>\n";
        }
        svg << "<text transform=\"translate(" << x0 + group * 0.3 << ' ' << height - bottom + 16
            << ") rotate(18)\" font-size=\"11\">" << tips[i].first << "</text>\n";
    }
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const double x = left + 150 * static_cast<double>(p);
        svg << "<rect x=\"" << x << "\" y=\"" << height - 24 << "\" width=\"12\" height=\"12\" fill=\"" << colours[p]
            << "\"/><text x=\"" << x + 18 << "\" y=\"" << height - 14 << "\">" << problem_names[p] << "</text>\n";
    }
    svg << "</svg>\n";
}

void two_phase(std::ostream& out) {
    out << "## Two-phase checkerboard against the Hashin-Shtrikman bounds\n\n"
        << "Unit cube of 6 roots, checks of 1/4 m, three levels (each check holds 8 cubes of leaves), E 1 and "
           "contrast, nu 0.3, half and\n"
        << "half. E of the nearest isotropic matrix, mean over the roots. The estimate goes level by level with nine "
           "unknowns per\n"
           "parent, so it may end above the upper bound, which holds for the true effective stiffness.\n\n| contrast | "
           "lower bound | average | "
           "mean_strain | "
           "uniform_stress | isolated | upper bound |\n|---|---|---|---|---|---|---|\n";
    auto checks = std::make_shared<VoxelImage>();
    checks->source = "checks";
    checks->size = {4, 4, 4};
    for (int i = 0; i < 64; ++i) checks->data.push_back(static_cast<std::byte>((i + i / 4 + i / 16) % 2));
    checks->place(Vec3::Constant(0.125), Mat3::Identity() / 4);
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 3);
    for (const auto& [contrast, low, high] : {std::array{10.0, 2.40, 4.20}, std::array{100.0, 2.95, 34.2}}) {
        const StiffnessFunction f(labels(checks, {{0, 0}, {1, 1}}),
                                  {{.young = constant(1)}, {.young = constant(contrast)}});
        const LeafMaterials leaves = integrate_leaves(tree, f);
        std::map<std::string, double> young;
        for (std::size_t p = 0; p < problems.size(); ++p) {
            const auto m = estimate_elasticity(tree, leaves, problems[p]);
            Sym6 mean;
            for (TetId t : tree.level(0))
                for (std::size_t i = 0; i < 21; ++i) mean.upper[i] += m.elasticity[t].upper[i] / 6;
            young[problem_names[p]] = representative_young(mean);
        }
        out << "| " << contrast << " | " << number(low) << " | " << number(young["average"]) << " | "
            << number(young["mean_strain"]) << " | " << number(young["uniform_stress"]) << " | "
            << number(young["isolated"]) << " | " << number(high) << " |\n";
    }
    out << '\n';
}

void ranges(std::ostream& out) {
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {8, 2, 2}), 2);
    out << "## Nonlinear samples and valid ranges\n\nT1 = 1e-2, T2 = 1e-4 sqrt(C_jj C_mm) for stress j under strain m. Half width: median "
           "over the "
           "tets with an end, mean of the six strains.\n\n"
        << "| material | level | tets | uniform | with an end | median half width | mean / largest difference of fit "
           "and tangent | "
           "fits not definite | trace below average | trace above uniform stress | ms "
           "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const NamedMaterial& material : beam_materials()) {
        EstimationSettings settings;
        settings.sampling.emplace();
        const auto m = estimate_elasticity(tree, integrate_leaves(tree, material.function), settings);
        for (const LevelReport& r : m.report) {
            std::vector<double> widths;
            for (TetId t : tree.level(r.level)) {
                if (m.valid_range.empty() || m.valid_range[t] == unbounded_range) continue;
                double width = 0;
                for (const auto& range : m.valid_range[t]) width += (range[1] - range[0]) / 12;
                widths.push_back(width);
            }
            std::sort(widths.begin(), widths.end());
            out << "| " << material.name << " | " << r.level << " | " << r.tets << " | " << r.uniform << " | "
                << r.finite_ranges << " | " << (widths.empty() ? "-" : number(widths[widths.size() / 2], 4)) << " | "
                << number(100 * r.mean_residual) << " % / " << number(100 * r.largest_residual) << " % | " << r.unfitted
                << " | " << number(100 * r.below_average, 1) << " % | " << number(100 * r.above_uniform_stress, 1)
                << " % | " << number(1e3 * r.seconds, 1) << " |\n";
        }
    }
    out << '\n';
}

void cost(std::ostream& out) {
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {16, 6, 6}), 2);
    const auto parents = static_cast<double>(tree.tet_count() - tree.tet_count(2));
    EstimationSettings sampled;
    sampled.sampling.emplace();
    out << "## Cost\n\n"
        << tree.tet_count() << " tets, " << number(parents, 0)
        << " parents. CPU time of all threads (the machine may have had other work), and wall clock.\n\n"
        << "| what | CPU s | wall s | parents / CPU s |\n|---|---|---|---|\n";
    struct Seconds {
        double cpu, wall;
    };
    const auto row = [&](const std::string& what, Seconds seconds, bool per_parent) {
        out << "| " << what << " | " << number(seconds.cpu, 3) << " | " << number(seconds.wall, 3) << " | "
            << (per_parent ? number(parents / seconds.cpu, 0) : "-") << " |\n";
    };
    const auto time = [&](const auto& body) -> Seconds {
        const auto start = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        body();
        return {static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
    };
    const StiffnessFunction gradient_function({.young = gradient(0, {0, 4}, {1e6, 1e8}, Interpolation::exponential)});
    const StiffnessFunction uniform(MaterialFunction{}),
        halves(layers(0, {2}), {{.young = constant(1e5)}, {.young = constant(1e7)}});
    LeafMaterials leaves;
    row("integrate leaves, gradient", time([&] { leaves = integrate_leaves(tree, gradient_function); }), false);
    row("all heterogeneous, linear `mean_strain` with both bounds",
        time([&] { estimate_elasticity(tree, leaves, CellProblem::mean_strain); }), true);
    row("all heterogeneous, nonlinear sampling", time([&] { estimate_elasticity(tree, leaves, sampled); }), true);
    leaves = integrate_leaves(tree, halves);
    row("two uniform halves, nonlinear sampling", time([&] { estimate_elasticity(tree, leaves, sampled); }), true);
    leaves = integrate_leaves(tree, uniform);
    row("uniform", time([&] { estimate_elasticity(tree, leaves, sampled); }), true);

    const fs::path directory = fs::temp_directory_path() / ("coarsening_report_" + std::to_string(::getpid()));
    row("first start, nonlinear sampling, cache written", time([&] {
            coarse_materials(tree, gradient_function, sampled, {directory, {}});
        }),
        false);
    CoarseMaterials cached;
    const Seconds warm = time([&] { cached = coarse_materials(tree, gradient_function, sampled, {directory, {}}); });
    row("second start, warm cache", warm, false);
    ENSURE(cached.from_cache, "the cache was not used");
    double bytes = 0;
    for (const auto& entry : fs::directory_iterator(directory)) bytes += static_cast<double>(fs::file_size(entry));
    fs::remove_all(directory);
    out << "\nWarm cache, per 100,000 matrices: " << number(1e5 * warm.cpu / static_cast<double>(tree.tet_count()), 3)
        << " s CPU, " << number(1e5 * warm.wall / static_cast<double>(tree.tet_count()), 3) << " s wall clock; "
        << number(bytes / 1e6, 1) << " MB on disk.\n";
}

std::string machine() {
    std::string model = "unknown CPU";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) {
            model = line.substr(line.find(':') + 2);
            break;
        }
    utsname system{};
    uname(&system);
    return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, Linux " + system.release;
}

}  // namespace

int main() {
    const fs::path folder = source_folder() / "tests/reports";
    fs::create_directories(folder);
    std::ostringstream out;
    const std::time_t now = std::time(nullptr);
    out << "# Elasticity matrices of coarse levels\n\n"
        << std::put_time(std::gmtime(&now), "%Y-%m-%d") << ", " << machine()
        << ". Made by `build/release/tests/coarsening_report`.\n\n";
    std::vector<std::pair<std::string, std::map<std::string, Tip>>> tips;
    cantilever(out, tips);
    write_plot(folder / "coarsening.svg", tips);
    two_phase(out);
    std::cerr << "two-phase done\n";
    ranges(out);
    std::cerr << "ranges done\n";
    cost(out);
    std::ofstream(folder / "coarsening.md") << out.str();
    std::cout << out.str();
}
