// The two promises of the first screen: the bunny moves in real time, and its pictures come at a useful rate. Steps the
// scene, once left alone and once pulled around, then renders it; writes tests/reports/live.md.
//
//     build/release/tests/render_live_report [REPORT]          (from the repository's root, on an idle machine)

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "engine/simulation/simulation.hpp"
#include "server/render/renderer.hpp"
#include "server/render/sequence.hpp"
#include "tests/support/hand.hpp"
#include "tests/support/project.hpp"
#include "tests/support/report.hpp"

using namespace tetfront;
using namespace tetfront::testing;

namespace {

constexpr int steps = 600;

struct Run {
    std::vector<double> milliseconds;
    double tets = 0, estimate = 0;
    int iterations = 0, changes = 0, inverted_steps = 0, troubled_steps = 0, not_finite = 0;

    [[nodiscard]] double at(double quantile) const {
        std::vector<double> sorted = milliseconds;
        std::sort(sorted.begin(), sorted.end());
        return sorted[static_cast<std::size_t>(quantile * static_cast<double>(sorted.size() - 1))];
    }
    [[nodiscard]] double rate() const {
        double total = 0;
        for (double ms : milliseconds) total += ms;
        return 1000 * static_cast<double>(milliseconds.size()) / total;
    }
};

/// The frame that a viewer would get is made after every step and its time counts.
Run run(const std::shared_ptr<const Model>& model, bool pulled) {
    Simulation simulation(model);
    Run result;
    const Hand hand(*model);
    for (int i = 0; i < steps; ++i) {
        const auto start = std::chrono::steady_clock::now();
        if (pulled) hand.move(simulation, i);
        const StepReport r = simulation.step();
        const auto frame = simulation.frame();
        result.milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        for (auto n : r.tets_by_level) result.tets += n / static_cast<double>(steps);
        result.estimate += r.estimate / steps;
        result.iterations += r.solver_iterations;
        result.changes += r.splits + r.merges;
        result.inverted_steps += r.inverted_tets > 0;
        result.troubled_steps += !r.converged || r.rejected || !r.warning.empty();
        for (const auto& p : frame->surface) result.not_finite += !(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
    }
    return result;
}

void row(std::ostream& out, const char* name, const Run& r) {
    out << "| " << name << " | " << number(r.rate(), "%.0f") << " | " << number(r.at(0.5)) << " / " << number(r.at(0.95)) << " / " << number(r.at(1))
        << " | " << number(r.tets, "%.0f") << " | " << r.iterations / steps << " | " << r.changes << " | " << number(100 * r.estimate) << " % | "
        << r.inverted_steps << " | " << r.troubled_steps << " | " << r.not_finite << " |\n";
}

}  // namespace

int main(int argc, char** argv) {
    const std::string path = argc > 1 ? argv[1] : source_folder() / "tests/reports/live.md";
    const auto model = build_model(load_scene(source_folder() / "assets/scenes/bunny.json"));
    const TetTree& tree = model->tree;
    const Run alone = run(model, false), pulled = run(model, true);
    std::shared_ptr<const Model> armadillo;
    if (std::filesystem::exists(source_folder() / "assets/models/armadillo.off"))
        armadillo = build_model(load_scene(source_folder() / "assets/scenes/armadillo.json"));

    const std::filesystem::path directory = std::filesystem::temp_directory_path() / "tetfront-live-report";
    std::filesystem::create_directories(directory);
    Simulation simulation(model);
    const View view = make_view(model->scene.view, *model->frame_model, 1280, 720);
    SequenceOptions options{.frames = 60, .directory = directory, .view = view, .title = model->scene.title, .text = {}};
    const double per_frame = 1 / (30 * model->scene.time_step);
    const SequenceReport pictures = render_sequence(
        options,
        [&](int index) {
            for (int i = 0; index > 0 && i < static_cast<int>(std::lround(per_frame)); ++i) simulation.step();
            return simulation.frame();
        },
        [](int) { return true; });
    std::filesystem::remove_all(directory);

    std::ofstream out(path);
    write_head(out, "The bunny, live and as pictures", "build/release/tests/render_live_report");
    out << "\nScene assets/scenes/bunny.json: " << tree.tet_count(0) << " root tets, " << tree.depth() << " levels, " << tree.tet_count(tree.depth())
        << " leaf tets, " << model->frame_model->triangles.size() << " surface triangles; order " << model->scene.front.order << ", tolerance "
        << model->scene.front.tolerance << ", time step 1/" << number(1 / model->scene.time_step, "%.0f") << " s.\n\n"
        << "## Steps\n\n" << steps << " steps, each with the frame for a viewer. Goal: 60 a second; no inverted tet, nothing that is not finite.\n\n"
        << "| | steps/s | ms: median / 95 % / worst | tets, mean | CG iterations a step | splits and merges | estimate, mean | steps with an inverted "
           "tet | steps with a warning | surface coordinates not finite |\n|---|---|---|---|---|---|---|---|---|---|\n";
    row(out, "left alone", alone);
    row(out, "pulled around", pulled);
    if (armadillo) {
        row(out, "the armadillo, left alone but for its scene's forces", run(armadillo, false));
        row(out, "the armadillo, pulled around", run(armadillo, true));
        out << "\nThe armadillo: assets/scenes/armadillo.json, " << armadillo->tree.tet_count(0) << " root tets, " << armadillo->tree.depth() << " levels, "
            << armadillo->tree.tet_count(armadillo->tree.depth()) << " leaf tets, " << armadillo->frame_model->triangles.size()
            << " surface triangles. Goal: 30 steps a second while pulled.\n";
    } else {
        out << "\nThe armadillo is not fetched: assets/fetch armadillo.\n";
    }
    out << "\n## Pictures\n\n1280x720, 2x2 samples a pixel, 60 frames of 1/30 s, simulation and PNG files included. Goal: 5 a second.\n\n"
        << "| frames/s | simulate | render | encode |\n|---|---|---|---|\n| " << number(pictures.written / pictures.seconds) << " | "
        << number(1000 * pictures.simulate / pictures.written) << " ms | " << number(1000 * pictures.render / pictures.written) << " ms | "
        << number(1000 * pictures.encode / pictures.written) << " ms |\n";
    if (!out.flush()) {
        std::cerr << "cannot write " << path << "\n";
        return 4;
    }
    std::cout << "wrote " << path << "\n";
    return 0;
}
