#include "server/cli/sweep.hpp"

#include "engine/base/error.hpp"
#include "engine/mechanics/adaptivity.hpp"
#include "server/cli/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tetfront {

namespace {

constexpr int block_steps = 16;
static_assert(block_steps % compare_every == 0);

/// What a reference looked like at one step.
struct Snapshot {
    PerVertex<Vec3> x;        // [V]
    double displacement = 0;  // root mean square over the longest edge, remembered
};

class Sweep {
 public:
    Sweep(const std::vector<SweepRun>& runs, std::size_t references) : runs_(runs), snapshots_(references) {
        ENSURE(references >= 1 && references <= runs.size(), "references ", references, " runs ", runs.size());
        vertices_ = runs[0].model->tree.vertex_count();
        for (const SweepRun& run : runs) {
            vertices_ = std::min(vertices_, run.model->tree.vertex_count());
            simulations_.emplace_back(run.model, run.front);
            SweepResult& result = results_.emplace_back();
            result.name = run.name;
            result.front = run.front;
            result.errors.resize(references);
            result.last_relative.resize(references, 0);
        }
        most_energy_.resize(runs.size(), 0);
        for (const SweepRun& run : runs)
            for (const VertexId v : ids<VertexId>(vertices_))
                ENSURE(run.model->tree.rest(v) == runs[0].model->tree.rest(v), run.name, " has another tree, vertex ", v.value);
    }

    /// `steps` more steps of every run.
    void advance(int steps, bool last_block, const SweepObserver& observer) {
        const auto compared = [&](int i) { return (i + 1) % compare_every == 0 || (last_block && i + 1 == steps); };
        comparisons_ += (steps + (last_block ? compare_every - 1 : 0)) / compare_every;
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            const bool reference = r < snapshots_.size();
            if (reference) snapshots_[r].resize(static_cast<std::size_t>(steps));
            for (int n = 0; n < steps; ++n) {
                count(r, simulations_[r].step());
                if (observer) observer(r, static_cast<int>(results_[r].step_tets.size()), simulations_[r]);
                if (!compared(n)) continue;
                const auto i = static_cast<std::size_t>(n);
                PerVertex<Vec3> x = simulations_[r].all_positions();
                x.resize(vertices_);
                if (reference) remember(r, i, std::move(x));
                for (std::size_t k = 0; k < std::min(r + 1, snapshots_.size()); ++k) {
                    const double relative = compare(results_[r].errors[k], snapshots_[k][i], reference ? snapshots_[r][i].x : x);
                    results_[r].last_relative[k] = relative;
                }
            }
        }
    }

    std::vector<SweepResult> finish(int steps) {
        for (SweepResult& r : results_) {
            r.changed /= std::max(r.tets, 1.0);
            for (double* sum : {&r.milliseconds, &r.tets, &r.estimate, &r.iterations}) *sum /= steps;
            for (SweepResult::Error& e : r.errors) {
                e.mean /= comparisons_;
                e.relative /= comparisons_;
            }
            const double most = most_energy_[static_cast<std::size_t>(&r - results_.data())];
            r.energy_changed = most > 0 ? r.energy_changed / most : 0;
        }
        return std::move(results_);
    }

 private:
    void count(std::size_t r, const StepReport& report) {
        SweepResult& result = results_[r];
        const double milliseconds = report.milliseconds.total();
        std::size_t tets = 0;
        for (const std::uint32_t n : report.tets_by_level) tets += n;
        result.milliseconds += milliseconds;
        result.step_milliseconds.push_back(milliseconds);
        result.step_tets.push_back(tets);
        result.tets += static_cast<double>(tets);
        result.most_tets = std::max(result.most_tets, tets);
        result.estimate += report.estimate;
        result.last_estimate = report.estimate;
        result.last_tets = static_cast<double>(tets);
        result.energy_changed = std::max(result.energy_changed, std::abs(report.energy_change) / std::max(1, report.splits + report.merges));  // [J] until finish()
        const Simulation::Energy energy = simulations_[r].energy();
        most_energy_[r] = std::max(most_energy_[r], energy.elastic + energy.kinetic);
        result.iterations += report.solver_iterations;
        result.changed += report.splits + report.merges;
        result.troubled += !report.converged || report.rejected ? 1 : 0;
    }

    void remember(std::size_t r, std::size_t i, PerVertex<Vec3> x) {
        const Model& model = *runs_[r].model;
        PerVertex<Vec3> rest = model.tree.rest();
        rest.resize(vertices_);
        // Energies decay with AdaptivitySettings::memory, displacements with their square root.
        const double decay = std::exp(-0.5 * compare_every * model.scene.time_step / AdaptivitySettings{}.memory);
        if (displacement_.size() <= r) displacement_.resize(r + 1, 0);
        displacement_[r] = std::max(decay * displacement_[r], difference(x, rest, model.size).root_mean_square);
        snapshots_[r][i] = {std::move(x), displacement_[r]};
    }

    /// Returns the relative error.
    double compare(SweepResult::Error& error, const Snapshot& reference, const PerVertex<Vec3>& x) const {
        const Difference d = difference(x, reference.x, runs_[0].model->size);
        error.mean += d.mean;
        error.max = std::max(error.max, d.max);
        error.steps.push_back({d.mean, d.max});
        const double relative = reference.displacement > 0 ? d.root_mean_square / reference.displacement : 0;
        error.relative += relative;
        return relative;
    }

    const std::vector<SweepRun>& runs_;
    std::size_t vertices_ = 0;  // that all trees have
    std::vector<Simulation> simulations_;
    std::vector<SweepResult> results_;
    std::vector<std::vector<Snapshot>> snapshots_;  // [references][steps of the block]
    std::vector<double> displacement_;              // [references]
    std::vector<double> most_energy_;               // [runs] [J]
    int comparisons_ = 0;
};

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

}  // namespace

std::vector<SweepResult> sweep(const std::vector<SweepRun>& runs, std::size_t references, int steps,
                               const std::function<void(double)>& progress, const SweepObserver& observer) {
    Sweep all(runs, references);
    for (int done = 0; done < steps;) {
        const int block = std::min(block_steps, steps - done);
        done += block;
        all.advance(block, done == steps, observer);
        if (progress) progress(static_cast<double>(done) / steps);
    }
    return all.finish(steps);
}

std::string describe_budget(const FrontSpec& front) {
    const bool tets = front.budget_tets < FrontSpec{}.budget_tets, time = front.budget_milliseconds > 0;
    if (!tets && !time) return "no budget";
    return "at most " + (tets ? std::to_string(front.budget_tets) + " tets" : "") + (tets && time ? " or " : "") +
           (time ? number(front.budget_milliseconds) + " ms a step" : "");
}

Chart speed_against_error(const std::string& title, const std::vector<SweepResult>& results, std::size_t reference) {
    Chart chart{.title = title,
                .subtitle = "Each line: one kind of front; the numbers beside its points are tolerances. Down and left is better.",
                .x = "milliseconds a step, mean",
                .y = "mean error, % of the longest edge",
                .series = {},
                .rules = {}};
    std::vector<Chart::Series> finest;
    for (const SweepResult& r : results) {
        const SweepResult::Error& error = r.errors[reference];
        const std::string order = r.front.order == 2 ? "quadratic" : "linear";
        const bool fixed = r.front.min_level >= r.front.max_level;
        if (&r == &results[reference]) {
            chart.rules.push_back({r.name + " (reference)", r.milliseconds});
        } else if (fixed) {
            finest.push_back({.name = r.name, .line = false, .points = {{r.milliseconds, 100 * error.mean, ""}}});
        } else {
            const std::string budget = describe_budget(r.front);
            const std::string name = "adaptive " + order + (budget == "no budget" ? "" : ", " + budget);
            auto series = std::ranges::find(chart.series, name, &Chart::Series::name);
            if (series == chart.series.end()) series = chart.series.insert(series, {.name = name, .line = true, .points = {}});
            series->points.push_back({r.milliseconds, 100 * error.mean, number(r.front.tolerance)});
        }
    }
    chart.series.insert(chart.series.end(), finest.begin(), finest.end());
    return chart;
}

}  // namespace tetfront
