#include "engine/base/error.hpp"
#include "engine/base/atomic_file.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/comparison.hpp"
#include "server/cli/progress_bar.hpp"
#include "server/cli/sweep.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tetfront {

namespace {

constexpr int most_levels = 6;
constexpr std::size_t most_runs = 200;  // each keeps a whole simulation in memory

struct StudyOptions {
    SceneArguments scene;
    std::vector<int> orders = {1, 2};
    std::vector<double> tolerances = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005};
    std::vector<std::string> budgets = {"none"};
    int steps = 120;
    double seconds = 0;  // 0: not given
    std::string reference = "finest", directory = "study";
};

struct Budget {
    int tets = FrontSpec{}.budget_tets;
    double milliseconds = 0;  // 0: no limit
};

/// "none", "500" or "5ms".
Budget parse_budget(const std::string& text) {
    if (text == "none") return {};
    Budget budget;
    const char* const end = text.data() + text.size();
    if (text.ends_with("ms")) {
        const auto read = std::from_chars(text.data(), end - 2, budget.milliseconds);
        if (read.ec == std::errc{} && read.ptr == end - 2 && budget.milliseconds > 0 && budget.milliseconds <= 1e6) return budget;
    } else {
        const auto read = std::from_chars(text.data(), end, budget.tets);
        if (read.ec == std::errc{} && read.ptr == end && budget.tets >= 1) return budget;
    }
    throw InputError("--budgets", text, "is no budget", "use a number of tets like 500, a time like 5ms, or none");
}

template <class T>
void sort_unique(std::vector<T>& values) {
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Throws InputError for what no parser has seen, before anything is written.
void check(const StudyOptions& options, const Scene& scene) {
    for (const std::string& budget : options.budgets) (void)parse_budget(budget);
    const std::size_t count = options.orders.size() * options.tolerances.size() * options.budgets.size();
    if (count > most_runs)
        throw InputError("", "", "the study would have " + std::to_string(count) + " runs",
                         "use at most " + std::to_string(most_runs) + ": fewer orders, tolerances or budgets");
    if (scene.levels == 0)
        throw InputError(scene.file.string(), "/levels", "is 0: every front is the same", "use levels >= 1");
    if (options.reference == "finer" && scene.levels == most_levels)
        throw InputError("--reference", "finer", "needs a level more than there can be", "use --reference finest or fewer levels");
}

int steps_of(const StudyOptions& options, const Scene& scene) {
    if (options.seconds == 0) return options.steps;
    const double steps = std::round(options.seconds / scene.time_step);
    if (!(steps >= 1 && steps <= 1e7))
        throw InputError("--seconds", "", "makes " + std::to_string(steps) + " steps", "use a time that makes 1 to 10000000");
    return static_cast<int>(steps);
}

struct Plan {
    std::vector<SweepRun> runs;  // the reference first
    std::string reference;
};

Plan make_plan(const StudyOptions& options, const Scene& scene, const Progress& progress) {
    std::vector<int> orders = options.orders;
    sort_unique(orders);
    std::vector<double> tolerances = options.tolerances;
    sort_unique(tolerances);
    std::ranges::reverse(tolerances);
    std::vector<Budget> budgets;
    for (const std::string& text : options.budgets) budgets.push_back(parse_budget(text));

    // The scene's own budget must not stop the finest levels nor the runs without one.
    Scene plain = scene;
    plain.front.budget_tets = Budget{}.tets;
    plain.front.budget_milliseconds = 0;
    plain.front.min_level = 0;
    plain.front.max_level = FrontSpec{}.max_level;
    const auto model = build_model(plain, progress, options.scene.cache());
    Plan plan;
    const SweepRun quadratic = {"finest quadratic", model, finest_front(plain, 2)};
    if (options.reference == "finer") {
        Scene deeper = plain;
        ++deeper.levels;
        plan.runs.push_back({"finer quadratic", build_model(deeper, progress, options.scene.cache()), finest_front(deeper, 2)});
    }
    plan.runs.push_back(quadratic);
    plan.reference = plan.runs.front().name;
    plan.runs.push_back({"finest linear", model, finest_front(plain, 1)});
    for (const int order : orders) {
        for (const Budget& budget : budgets) {
            for (const double tolerance : tolerances) {
                FrontSpec front = scene.front;
                front.order = order;
                front.tolerance = tolerance;
                front.budget_tets = budget.tets;
                front.budget_milliseconds = budget.milliseconds;
                plan.runs.push_back({order == 2 ? "quadratic" : "linear", model, front});
            }
        }
    }
    return plan;
}

std::string number(double value, const char* format = "%.9g") {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/// Errors are fractions, empty for the reference itself.
std::string to_csv(const std::vector<SweepResult>& results) {
    std::string csv =
        "front,order,tolerance,budget_tets,budget_milliseconds,milliseconds_per_step,tets_mean,tets_max,error_mean,error_max,"
        "relative_error,estimate,cg_iterations_per_step,front_changed_per_step,steps_in_trouble\n";
    for (const SweepResult& r : results) {
        const SweepResult::Error& e = r.errors[0];
        const bool reference = &r == results.data(), fixed = r.front.min_level >= r.front.max_level;
        const bool tets = r.front.budget_tets < Budget{}.tets;
        csv += (fixed ? '"' + r.name + '"' : "adaptive") + ',' + std::to_string(r.front.order) + ',' +
               (fixed ? "" : number(r.front.tolerance)) + ',' + (fixed || !tets ? "" : std::to_string(r.front.budget_tets)) + ',' +
               (fixed || !(r.front.budget_milliseconds > 0) ? "" : number(r.front.budget_milliseconds)) + ',' +
               number(r.milliseconds) + ',' + number(r.tets) + ',' + std::to_string(r.most_tets) + ',' +
               (reference ? ",," : number(e.mean) + ',' + number(e.max) + ',' + number(e.relative)) + ',' + number(r.estimate) + ',' +
               number(r.iterations) + ',' + number(r.changed) + ',' + std::to_string(r.troubled) + '\n';
    }
    return csv;
}

void print(const std::vector<SweepResult>& results, const std::string& reference) {
    std::printf("errors against %s: distance of all vertices over the longest edge of the rest box\n", reference.c_str());
    std::printf("%-26s %9s %-24s %9s %11s %10s %10s\n", "front", "tolerance", "budget", "tets", "ms a step", "mean", "max");
    for (const SweepResult& r : results) {
        const SweepResult::Error& e = r.errors[0];
        const bool fixed = r.front.min_level >= r.front.max_level;
        std::printf("%-26s %9s %-24s %9.0f %11.3f %8.3f %% %8.3f %%\n", r.name.c_str(),
                    fixed ? "" : number(r.front.tolerance, "%g").c_str(), fixed ? "" : describe_budget(r.front).c_str(), r.tets,
                    r.milliseconds, 100 * e.mean, 100 * e.max);
        if (r.troubled > 0) std::printf("  TROUBLE: %d steps did not converge or were rejected\n", r.troubled);
    }
}

int study(const StudyOptions& options) {
    const Scene scene = options.scene.load();
    const int steps = steps_of(options, scene);
    check(options, scene);
    const std::filesystem::path directory = options.directory, csv = directory / "study.csv", svg = directory / "study.svg";
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) throw OutputError(directory.string() + ": cannot be made: " + error.message());
    check_writable(csv);
    check_writable(svg);

    std::vector<SweepResult> results;
    std::string reference;
    {
        ProgressBar bar("");
        const Plan plan = make_plan(options, scene, [&bar](const std::string& what, double fraction) { bar.show(what, fraction); });
        reference = plan.reference;
        results = sweep(plan.runs, 1, steps, [&bar](double fraction) { bar.show("studying", fraction); });
    }
    write_atomically(csv, to_csv(results));
    write_atomically(svg, to_svg(speed_against_error("Speed against error: " + scene.name, results, 0)));
    print(results, reference);
    std::printf("wrote %s and %s\n", csv.c_str(), svg.c_str());
    return exit_ok;
}

}  // namespace

void add_study(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand(
        "study", "Error against time per step: sweeps order x tolerance x budget beside the finest levels; CSV and picture");
    const auto options = std::make_shared<StudyOptions>();
    StudyOptions& o = *options;
    o.scene.add_to(*command);
    command->add_option("--orders", o.orders, "1 linear, 2 quadratic")->delimiter(',')->allow_extra_args(false)->check(CLI::Range(1, 2))->capture_default_str();
    command->add_option("--tolerances", o.tolerances, "Of the fronts, each in 1e-6..1")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(1e-6, 1.0))
        ->capture_default_str();
    command->add_option("--budgets", o.budgets, "Tets (500), time per step (5ms) or none")->delimiter(',')->allow_extra_args(false)->capture_default_str();
    CLI::Option* steps = command->add_option("--steps,--frames", o.steps, "Time steps of each run")
                             ->check(CLI::Range(1, 10'000'000))
                             ->capture_default_str();
    command->add_option("--seconds", o.seconds, "The same as simulated time [s]")->check(CLI::PositiveNumber)->excludes(steps);
    command
        ->add_option("--reference", o.reference,
                     "What errors are against: finest, the scene's finest quadratic level; or finer, a level below it, slow")
        ->check(CLI::IsMember({"finest", "finer"}))
        ->capture_default_str();
    command->add_option("--out", o.directory, "Directory for study.csv and study.svg")->type_name("DIR")->capture_default_str();
    command->callback([options, &action] { action = [options] { return study(*options); }; });
}

}  // namespace tetfront
