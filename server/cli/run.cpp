#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "engine/simulation/simulation.hpp"
#include "engine/simulation/snapshot.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/comparison.hpp"
#include "server/cli/progress_bar.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::ordered_json;

struct RunOptions {
    SceneArguments scene;
    int steps = 600;
    bool equilibrium = false;
    std::string report;
    std::vector<std::string> compare;
    std::string save, resume;
    int save_every = 0;  // steps; 0: at the end only
};

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

/// A column of numbers over the steps: total, median, mean, largest.
struct Series {
    std::vector<double> values;

    void add(double value) { values.push_back(value); }
    [[nodiscard]] double total() const {
        double sum = 0;
        for (const double value : values) sum += value;
        return sum;
    }
    [[nodiscard]] double mean() const { return values.empty() ? 0 : total() / static_cast<double>(values.size()); }
    [[nodiscard]] double largest() const { return values.empty() ? 0 : *std::ranges::max_element(values); }
    [[nodiscard]] double middle() const { return median(values); }
};

/// Collects what the steps did, and puts it in words: the report's JSON and the lines on stdout.
class RunRecord {
 public:
    explicit RunRecord(std::vector<Comparison>& comparisons) : comparisons_(comparisons), errors_(comparisons.size()) {}

    void add(const StepReport& r, const std::vector<Comparison::Step>& compared) {
        const auto& ms = r.milliseconds;
        Json step = {{"step", r.step},
                     {"time", r.time},
                     {"tets_by_level", r.tets_by_level},
                     {"free_vertices", r.free_vertices},
                     {"hanging_vertices", r.hanging_vertices},
                     {"splits", r.splits},
                     {"merges", r.merges},
                     {"milliseconds",
                      {{"total", ms.total()},
                       {"adapt", ms.adapt},
                       {"setup", ms.setup},
                       {"assemble", ms.assemble},
                       {"solve", ms.solve},
                       {"other", ms.other}}},
                     {"newton_iterations", r.newton_iterations},
                     {"solver_iterations", r.solver_iterations},
                     {"substeps", r.substeps},
                     {"residual", r.residual},
                     {"converged", r.converged},
                     {"rejected", r.rejected},
                     {"inverted_tets", r.inverted_tets},
                     {"estimate", r.estimate},
                     {"warning", r.warning}};
        double tets = 0;
        for (const std::uint32_t n : r.tets_by_level) tets += n;
        tets_.add(tets);
        total_.add(ms.total());
        adapt_.add(ms.adapt);
        setup_.add(ms.setup);
        assemble_.add(ms.assemble);
        solve_.add(ms.solve);
        other_.add(ms.other);
        iterations_.add(r.solver_iterations);
        estimate_.add(r.estimate);
        splits_ += r.splits;
        merges_ += r.merges;
        unconverged_ += r.converged ? 0 : 1;
        rejected_ += r.rejected ? 1 : 0;
        inverted_ += r.inverted_tets > 0 ? 1 : 0;
        for (std::size_t i = 0; i < compared.size(); ++i) {
            const Comparison::Step& c = compared[i];
            step["compare"][comparisons_[i].name()] = {{"milliseconds", c.milliseconds},
                                                       {"error_mean", c.difference.mean},
                                                       {"error_max", c.difference.max},
                                                       {"converged", c.converged},
                                                       {"time_ratio", ratio(c.milliseconds, ms.total())}};
            errors_[i].milliseconds.add(c.milliseconds);
            errors_[i].mean.add(c.difference.mean);
            errors_[i].max.add(c.difference.max);
            errors_[i].unconverged += c.converged ? 0 : 1;
        }
        steps_.push_back(std::move(step));
    }

    Json& steps() { return steps_; }

    [[nodiscard]] Json summary() const {
        Json result = {{"steps", total_.values.size()},
                       {"simulated_time", steps_.empty() ? Json(0) : steps_.back()["time"]},
                       {"milliseconds_total", total_.total()},
                       {"milliseconds_median",
                        {{"total", total_.middle()},
                         {"adapt", adapt_.middle()},
                         {"setup", setup_.middle()},
                         {"assemble", assemble_.middle()},
                         {"solve", solve_.middle()},
                         {"other", other_.middle()}}},
                       {"steps_per_second", ratio(1000.0 * static_cast<double>(total_.values.size()), total_.total())},
                       {"tets_median", tets_.middle()},
                       {"tets_max", tets_.largest()},
                       {"solver_iterations_total", iterations_.total()},
                       {"solver_iterations_median", iterations_.middle()},
                       {"estimate_median", estimate_.middle()},
                       {"estimate_max", estimate_.largest()},
                       {"splits", splits_},
                       {"merges", merges_},
                       {"steps_not_converged", unconverged_},
                       {"steps_rejected", rejected_},
                       {"steps_with_inverted_tets", inverted_}};
        for (std::size_t i = 0; i < errors_.size(); ++i) {
            const auto& e = errors_[i];
            result["compare"][comparisons_[i].name()] = {{"order", comparisons_[i].front().order},
                                                         {"level", comparisons_[i].front().max_level},
                                                         {"tets", comparisons_[i].tets()},
                                                         {"error_mean", e.mean.mean()},
                                                         {"error_max", e.max.largest()},
                                                         {"milliseconds_total", e.milliseconds.total()},
                                                         {"milliseconds_median", e.milliseconds.middle()},
                                                         {"time_ratio", ratio(e.milliseconds.total(), total_.total())},
                                                         {"steps_not_converged", e.unconverged}};
        }
        return result;
    }

    void print() const {
        std::printf("%zu steps in %.3g s of computing: %.3g ms each in the median, %.4g steps/s\n",
                    total_.values.size(), total_.total() / 1000, total_.middle(),
                    1000 * static_cast<double>(total_.values.size()) / std::max(total_.total(), 1e-9));
        std::printf("  median ms: adapt %.3g, setup %.3g, assemble %.3g, solve %.3g, other %.3g\n", adapt_.middle(),
                    setup_.middle(), assemble_.middle(), solve_.middle(), other_.middle());
        std::printf("  front: %.0f tets in the median, %.0f at most; %d splits, %d merges\n", tets_.middle(),
                    tets_.largest(), splits_, merges_);
        std::printf("  solver: %.0f iterations in the median; estimated error %.3g %% in the median, %.3g %% at most\n",
                    iterations_.middle(), 100 * estimate_.middle(), 100 * estimate_.largest());
        if (unconverged_ + rejected_ + inverted_ > 0)
            std::printf("  TROUBLE: steps not converged %d, rejected %d, with inverted tets %d\n", unconverged_,
                        rejected_, inverted_);
        for (std::size_t i = 0; i < errors_.size(); ++i) {
            const auto& e = errors_[i];
            std::printf(
                "against %s (order %d, level %d, %zu tets): error %.3g %% in the mean, %.3g %% at most; %.3g times "
                "its speed\n",
                comparisons_[i].name().c_str(), comparisons_[i].front().order, comparisons_[i].front().max_level,
                comparisons_[i].tets(), 100 * e.mean.mean(), 100 * e.max.largest(),
                e.milliseconds.total() / std::max(total_.total(), 1e-9));
            if (e.unconverged > 0) std::printf("  TROUBLE: it did not converge in %d steps\n", e.unconverged);
        }
    }

 private:
    static Json ratio(double numerator, double denominator) {
        return denominator > 0 ? Json(numerator / denominator) : Json(nullptr);
    }

    struct Errors {
        Series milliseconds, mean, max;
        int unconverged = 0;
    };
    std::vector<Comparison>& comparisons_;
    std::vector<Errors> errors_;  // [comparisons]
    Json steps_ = Json::array();
    Series tets_, total_, adapt_, setup_, assemble_, solve_, other_, iterations_, estimate_;
    int splits_ = 0, merges_ = 0, unconverged_ = 0, rejected_ = 0, inverted_ = 0;
};

Json model_json(const Model& model) {
    Json tets = Json::array(), vertices = Json::array();
    for (int level = 0; level <= model.tree.depth(); ++level) {
        tets.push_back(model.tree.tet_count(level));
        vertices.push_back(model.tree.vertex_count(level));
    }
    return {{"tets_by_level", tets},
            {"vertices_by_level", vertices},
            {"surface_vertices", model.surface.mesh.positions.size()},
            {"surface_triangles", model.surface.mesh.triangles.size()}};
}

std::string hexadecimal(std::uint64_t value) {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

int run(const RunOptions& options) {
    const Scene scene = options.scene.load();
    if (!options.report.empty()) {
        check_not_same(options.report, options.scene.file);
        check_writable(options.report);  // before the work, not after it
    }
    if (!options.save.empty()) {
        check_not_same(options.save, options.scene.file);
        check_writable(options.save);
    }
    std::vector<int> orders;
    for (const std::string& name : options.compare) orders.push_back(comparison_order(name, scene.front.order));

    ProgressBar bar("");
    const Progress progress = [&bar](const std::string& what, double fraction) { bar.show(what, fraction); };
    const auto model = build_model(scene, progress, options.scene.cache());
    Simulation simulation(model);
    int first = 0;
    if (!options.resume.empty()) {
        const std::uint64_t done = load_snapshot(options.resume, simulation);
        if (done >= static_cast<std::uint64_t>(options.steps)) {
            throw InputError(options.resume, "snapshot", "has made " + std::to_string(done) + " of " + std::to_string(options.steps) + " steps",
                             "use --steps for more than that: it counts from the beginning");
        }
        first = static_cast<int>(done);
    }
    std::vector<Comparison> comparisons;
    for (std::size_t i = 0; i < orders.size(); ++i) comparisons.emplace_back(options.compare[i], model, orders[i]);

    RunRecord record(comparisons);
    {
        ProgressBar steps("steps");
        std::vector<Comparison::Step> compared(comparisons.size());
        const int count = options.equilibrium ? 1 : options.steps;
        for (int i = first; i < count; ++i) {
            const StepReport report = options.equilibrium ? simulation.settle() : simulation.step();
            if (options.equilibrium && !report.converged) std::fprintf(stderr, "warning: %s\n", report.warning.c_str());
            const bool last = i + 1 == count;
            if (!options.save.empty() && (last || (options.save_every > 0 && (i + 1) % options.save_every == 0)))
                save_snapshot(options.save, simulation);
            for (std::size_t k = 0; k < comparisons.size(); ++k) compared[k] = comparisons[k].step(simulation);
            record.add(report, compared);
            steps.show(static_cast<std::size_t>(i + 1), static_cast<std::size_t>(count));
        }
    }
    const std::string state_hash = hexadecimal(simulation.hash());
    if (!options.report.empty()) {
        const Json report = {
            {"tetfront", TETFRONT_VERSION},
            {"scene", {{"name", scene.name}, {"file", options.scene.file}, {"set", options.scene.settings}}},
            {"order", scene.front.order},
            {"tolerance", scene.front.tolerance},
            {"time_step", scene.time_step},
            {"model", model_json(*model)},
            {"resumed_at_step", first},
            {"state_hash", state_hash},
            {"summary", record.summary()},
            {"steps", std::move(record.steps())}};
        write_atomically(options.report, report.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    record.print();
    std::printf("state after step %d: %s\n", options.steps, state_hash.c_str());
    return exit_ok;
}

}  // namespace

void add_run(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("run", "Simulates without pictures and reports what each step did");
    const auto options = std::make_shared<RunOptions>();
    options->scene.add_to(*command);
    command->add_option("--steps", options->steps, "How many, from the beginning")->check(CLI::Range(1, 10'000'000))->capture_default_str();
    CLI::Option* equilibrium = command->add_flag("--static", options->equilibrium, "Finds the equilibrium at time 0 instead of making steps")->excludes("--steps");
    command->add_option("--report", options->report, "JSON file for all numbers of all steps")->type_name("FILE");
    CLI::Option* save =
        command->add_option("--save", options->save, "File for the complete state after the last step, to go on from")->type_name("FILE");
    command->add_option("--save-every", options->save_every, "Also saves the state after every so many steps")
        ->type_name("STEPS")
        ->check(CLI::Range(1, 10'000'000))
        ->needs(save);
    CLI::Option* resume = command
                              ->add_option("--resume", options->resume,
                                           "Goes on from a saved state of this scene with these settings, up to --steps in all: to "
                                           "the bit as if it had not been interrupted")
                              ->type_name("FILE");
    command
        ->add_option(
            "--compare", options->compare,
            "Runs this beside it and reports the difference: finest (same order), finest-linear, finest-quadratic; "
            "repeatable")
        ->type_name("WHAT")
        ->allow_extra_args(false)
        ->excludes(resume)
        ->excludes(equilibrium);
    equilibrium->excludes(resume);
    command->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace tetfront
