// Speed against error: adaptive fronts of both orders beside the finest levels, over whole runs.
// Writes tests/reports/accuracy.md.
//
//     build/release/tests/accuracy_report [STEPS] [REPORT]     (from the repository's root, on an idle machine)
//
// Errors as in [Imai]: distance of all finest vertices to the finest quadratic level's over the longest edge of the rest
// box. All runs of a table take turns step by step in one process, so that their times compare.

#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "engine/simulation/simulation.hpp"
#include "tests/support/report.hpp"

using namespace tetfront;
using namespace tetfront::testing;

namespace {

struct Case {
    const char* title;
    const char* scene;
    std::vector<Override> overrides;
};

struct Run {
    std::string name;
    Simulation simulation;
    double milliseconds = 0, tets = 0, estimate = 0, error_mean = 0, error_max = 0, relative_error = 0;
    int iterations = 0, changes = 0, troubled = 0;
};

FrontSpec adaptive(int order, double tolerance) {
    FrontSpec front;
    front.order = order;
    front.tolerance = tolerance;
    return front;
}
FrontSpec finest(int order) {
    FrontSpec front = adaptive(order, 1);
    front.min_level = 99;
    return front;
}

void step(Run& run) {
    const StepReport r = run.simulation.step();
    run.milliseconds += r.milliseconds.total();
    for (auto n : r.tets_by_level) run.tets += n;
    run.estimate += r.estimate;
    run.iterations += r.solver_iterations;
    run.changes += r.splits + r.merges;
    run.troubled += !r.converged || r.rejected;
}

void compare(Run& run, const PerVertex<Vec3>& reference, const Model& model) {
    const PerVertex<Vec3> x = run.simulation.all_positions();
    double sum = 0, largest = 0, error2 = 0, displacement2 = 0;
    for (VertexId v : ids<VertexId>(x.size())) {
        const double d = (x[v] - reference[v]).norm();
        sum += d;
        largest = std::max(largest, d);
        error2 += d * d;
        displacement2 += (reference[v] - model.tree.rest(v)).squaredNorm();
    }
    run.error_mean += sum / static_cast<double>(x.size()) / model.size;
    run.error_max = std::max(run.error_max, largest / model.size);
    if (displacement2 > 0) run.relative_error += std::sqrt(error2 / displacement2);
}

void table(std::ostream& out, const Case& c, int steps) {
    std::cerr << c.title << "\n";
    const auto model = build_model(load_scene(std::string(TETFRONT_SOURCE_DIR "/assets/scenes/") + c.scene, c.overrides));
    std::vector<Run> runs;
    runs.push_back({"finest quadratic (reference)", Simulation(model, finest(2))});
    runs.push_back({"finest linear", Simulation(model, finest(1))});
    for (double tolerance : {0.05, 0.02, 0.01, 0.005}) runs.push_back({"quadratic, tolerance " + number(tolerance), Simulation(model, adaptive(2, tolerance))});
    for (double tolerance : {0.2, 0.1, 0.05}) runs.push_back({"linear, tolerance " + number(tolerance), Simulation(model, adaptive(1, tolerance))});
    for (int i = 0; i < steps; ++i) {
        for (Run& run : runs) step(run);
        const PerVertex<Vec3> reference = runs[0].simulation.all_positions();
        for (Run& run : runs) compare(run, reference, *model);
    }
    const double linear = runs[1].milliseconds;
    out << "\n## " << c.title << "\n\n`" << c.scene << "`";
    for (const auto& [pointer, value] : c.overrides) out << " `--set " << pointer.substr(1) << "=" << value << "`";
    out << ": " << model->tree.tet_count(0) << " root tets, " << model->tree.tet_count(model->tree.depth()) << " leaf tets, " << steps << " steps.\n\n"
        << "| front | tets, mean | error: mean | error: max | ms a step | time: finest linear over this | relative displacement error | estimate | "
           "estimate / error | CG iterations a step | front changed a step | steps in trouble |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const Run& r : runs) {
        const bool reference = &r == runs.data();
        out << "| " << r.name << " | " << number(r.tets / steps, "%.0f") << " | " << (reference ? "-" : number(100 * r.error_mean / steps, "%.3f") + " %")
            << " | " << (reference ? "-" : number(100 * r.error_max, "%.2f") + " %") << " | " << number(r.milliseconds / steps, "%.2f") << " | "
            << number(linear / r.milliseconds, "%.1f") << " | " << (reference ? "-" : number(100 * r.relative_error / steps, "%.2f") + " %") << " | "
            << number(100 * r.estimate / steps, "%.2f") << " % | " << (reference ? "-" : number(r.estimate / r.relative_error, "%.2f")) << " | "
            << r.iterations / steps << " | " << number(100 * r.changes / r.tets, "%.2f") << " % | " << r.troubled << " |\n";
    }
}

}  // namespace

int main(int argc, char** argv) {
    const int steps = argc > 1 ? std::max(1, std::atoi(argv[1])) : 240;
    const std::string path = argc > 2 ? argv[2] : TETFRONT_SOURCE_DIR "/tests/reports/accuracy.md";
    std::ofstream out(path);
    write_head(out, "Speed against error", "build/release/tests/accuracy_report " + std::to_string(steps));
    out << "\nErrors are distances of all vertices of the finest level to those of the finest quadratic front, over the longest edge of the\n"
           "rest box: the mean over vertices and steps, and the largest of all. The relative displacement error is the root mean square\n"
           "of these distances over that of the displacements, mean over the steps; the estimate is what a step reports. In heterogeneous\n"
           "scenes the finest quadratic front, one level above the leaves, is itself not the truth.\n";
    const std::vector<Case> cases = {
        {"Box under gravity, 2 levels", "box.json", {}},
        {"Box under gravity, 3 levels", "box.json", {{"/levels", "3"}}},
        {"Box pulled at one side, 2 levels", "pull.json", {}},
        {"Box of graded stiffness, 2 levels", "gradient.json", {}},
        {"Bunny under gravity", "bunny.json", {{"/levels", "2"}}},
    };
    for (const Case& c : cases) {
        table(out, c, steps);
        out.flush();
    }
    if (!out) {
        std::cerr << "cannot write " << path << "\n";
        return 4;
    }
    std::cout << "wrote " << path << "\n";
    return 0;
}
