#include "engine/mesh/tet_mesh.hpp"
#include "engine/simulation/shape.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/progress_bar.hpp"
#include "server/session/recording.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tetfront {

namespace {

struct LevelQuality {
    double smallest = 180, largest = 0;  // [degrees] dihedral angles of the worst tets
    double median = 0;                   // of the tets' smallest dihedral angles
    double smallest_volume = 0, largest_volume = 0;
    double mass = 0;  // [kg]
};

LevelQuality quality(const Model& model, int level) {
    const TetTree& tree = model.tree;
    LevelQuality q;
    std::vector<double> smallest;
    smallest.reserve(tree.tet_count(level));
    q.smallest_volume = std::numeric_limits<double>::infinity();
    for (const TetId t : tree.level(level)) {
        const auto& c = tree.corners(t);
        const auto [low, high] = dihedral_range(tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3]));
        smallest.push_back(low);
        q.smallest = std::min(q.smallest, low);
        q.largest = std::max(q.largest, high);
        q.smallest_volume = std::min(q.smallest_volume, tree.volume(t));
        q.largest_volume = std::max(q.largest_volume, tree.volume(t));
        q.mass += model.density[t] * tree.volume(t);
    }
    const auto middle = smallest.begin() + static_cast<std::ptrdiff_t>(smallest.size() / 2);
    std::nth_element(smallest.begin(), middle, smallest.end());
    q.median = *middle;
    return q;
}

template <class T>
double mebibytes(const std::vector<T>& values) {
    return static_cast<double>(values.size() * sizeof(T)) / (1 << 20);
}

/// How far each level's matrices are from both bounds, and how the fits of their nonlinear samples went.
void print_coarsening(const ElasticityMatrices& matrices) {
    std::printf("\n");
    if (matrices.report.empty()) {
        std::printf("coarsening the material is uniform: all levels have the leaves' matrix, valid at any strain\n");
        return;
    }
    const auto row = [](const char* format, auto... values) { std::printf(format, values...); };
    row("%5s %10s %10s %10s %10s %15s %10s %10s %9s %8s\n", "level", "tets", "uniform", "below", "above uni-",
        "range ends", "residual", "residual", "not", "time");
    row("%5s %10s %10s %10s %10s %15s %10s %10s %9s %8s\n", "", "", "", "average", "form stress", "somewhere", "mean",
        "largest", "fitted", "[s]");
    for (const LevelReport& r : matrices.report) {
        row("%5d %10lld %10lld %8.1f %% %9.1f %% %15d %8.2f %% %8.2f %% %9lld %8.2f\n", r.level,
            static_cast<long long>(r.tets), static_cast<long long>(r.uniform), 100 * r.below_average,
            100 * r.above_uniform_stress, r.finite_ranges, 100 * r.mean_residual, 100 * r.largest_residual,
            static_cast<long long>(r.unfitted), r.seconds);
    }
    row("below, above: means over the tets of the trace's distance to each bound, over the trace; 0 %% is at that bound.\n"
        "residual: of the fit to nonlinear samples against the tangent at rest. Times are those of the computation, also "
        "when\nthe matrices came from the cache.\n");
}

int info_of_recording(const std::string& file) {
    const Recording recording(file);
    const RecordingInfo& about = recording.info();
    const std::size_t frames = recording.frame_count();
    std::printf("recording  %s%s%s\n", about.name.c_str(), about.title.empty() ? "" : ": ", about.title.c_str());
    std::printf("made by    %s\n", about.software.c_str());
    std::printf("frames     %zu, from %g s to %g s, %g a second%s\n", frames, recording.time(0), recording.time(frames - 1),
                about.fps, recording.complete() ? "" : "; it was cut short");
    std::printf("surface    %zu vertices, %zu triangles, levels 0..%d, order %d\n", recording.model()->young.size(),
                recording.model()->triangles.size(), recording.model()->depth, about.order);
    std::printf("values     %s\n", about.field == Field::none ? "none; colouring by level or stiffness only"
                                                              : name(about.view.colouring).c_str());
    for (const RecordedEvent& event : recording.events()) std::printf("%9.3f s  %s\n", event.time, event.json.c_str());
    return exit_ok;
}

int info(const SceneArguments& arguments, bool coarsening) {
    if (is_recording(arguments.file)) return info_of_recording(arguments.file);
    ProgressBar bar("");
    bar.show("meshing", 0);
    const Scene described = arguments.load();
    Shape shape = make_shape(described);
    const std::string meshing = describe(shape);
    const auto model = build_model(
        described, std::move(shape), [&bar](const std::string& what, double done) { bar.show(what, done); }, arguments.cache());
    bar.clear();
    const Scene& scene = model->scene;
    const TetTree& tree = model->tree;
    const FrameModel& frame = *model->frame_model;

    std::printf("scene      %s%s%s\n", scene.name.c_str(), scene.title.empty() ? "" : ": ", scene.title.c_str());
    std::printf("levels     0..%d, order %d, tolerance %g, time step %g s\n\n", tree.depth(), scene.front.order,
                scene.front.tolerance, scene.time_step);
    std::printf("%5s %12s %12s %11s %11s %11s %13s %13s %12s\n", "level", "tets", "vertices", "smallest", "median",
                "largest", "smallest tet", "largest tet", "mass");
    std::printf("%5s %12s %12s %11s %11s %11s %13s %13s %12s\n", "", "", "", "angle [deg]", "of smallest",
                "angle [deg]", "[m^3]", "[m^3]", "[kg]");
    for (int level = 0; level <= tree.depth(); ++level) {
        const LevelQuality q = quality(*model, level);
        std::printf("%5d %12zu %12zu %11.1f %11.1f %11.1f %13.3g %13.3g %12.6g\n", level, tree.tet_count(level),
                    tree.vertex_count(level), q.smallest, q.median, q.largest, q.smallest_volume, q.largest_volume,
                    q.mass);
    }
    std::printf("\nstiffness  %zu material%s, Young's modulus %g..%g Pa at the surface\n", scene.material.materials.size(),
                scene.material.materials.size() == 1 ? "" : "s", static_cast<double>(frame.young_range[0]),
                static_cast<double>(frame.young_range[1]));
    std::printf("surface    %zu vertices, %zu triangles, %zu vertices outside of all tets (at most %g m)\n",
                model->surface.mesh.positions.size(), model->surface.mesh.triangles.size(),
                model->surface.outside_count, model->surface.outside_distance);
    const auto& box = frame.rest_box;
    std::printf("rest box   %g %g %g .. %g %g %g m, up is %c\n", static_cast<double>(box[0]),
                static_cast<double>(box[1]), static_cast<double>(box[2]), static_cast<double>(box[3]),
                static_cast<double>(box[4]), static_cast<double>(box[5]), "xyz"[frame.up]);
    const double tree_memory = static_cast<double>(tree.memory_bytes()) / (1 << 20);
    const auto& m = model->matrices;
    const double matrix_memory = static_cast<double>(m.elasticity.memory_bytes() + m.bracket.memory_bytes() +
                                                     m.valid_range.memory_bytes()) / (1 << 20) +
                                 mebibytes<double>(model->density) + mebibytes<double>(model->matrices.mass_damping) +
                                 mebibytes<double>(model->matrices.stiffness_damping);
    std::printf("memory     tree %.1f MiB, matrices %.1f MiB\n", tree_memory, matrix_memory);
    if (!meshing.empty()) std::printf("\nimported and meshed\n%s", meshing.c_str());
    if (coarsening) print_coarsening(model->matrices);
    return exit_ok;
}

}  // namespace

void add_info(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("info", "Prints what a scene or a recording consists of");
    const auto arguments = std::make_shared<SceneArguments>();
    const auto coarsening = std::make_shared<bool>(false);
    arguments->add_to(*command);
    command->add_flag("--coarsening", *coarsening, "Also how the elasticity matrices of coarse levels were found");
    command->callback(
        [arguments, coarsening, &action] { action = [=] { return info(*arguments, *coarsening); }; });
}

}  // namespace tetfront
