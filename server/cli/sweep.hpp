#pragma once
// Many fronts of one scene side by side: what each costs a step and how far it is off. The numbers behind
// `tetfront study` and the accuracy report.
//
//     std::vector<SweepRun> runs = {{"finest quadratic", model, finest_front(scene, 2)}, {"linear", model, front}};
//     for (const SweepResult& r : sweep(runs, 1, 240)) ... r.milliseconds, r.errors[0].mean ...
//
// All runs advance together in one process, a few steps at a time: whatever else the machine does hits all alike, and
// each still works with warm caches, as it would alone.

#include "engine/simulation/simulation.hpp"
#include "server/cli/chart.hpp"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tetfront {

struct SweepRun {
    std::string name;
    std::shared_ptr<const Model> model;
    FrontSpec front;
};

/// Means over the steps, unless they say otherwise.
struct SweepResult {
    std::string name;
    FrontSpec front;
    double milliseconds = 0;  // a step
    double tets = 0;
    std::size_t most_tets = 0;
    /// Against one reference: distances of vertices over the longest edge of the rest box, as in [Imai].
    struct Error {
        double mean = 0;
        double max = 0;  // of all vertices and steps
        /// Root mean square of the distances over that of the displacements; these are remembered like the energy that
        /// the estimate is relative to (AdaptivitySettings::memory), so that both speak of the same thing.
        double relative = 0;
        std::vector<std::array<double, 2>> steps;  // mean and max of each compared step, every compare_every and the last
    };
    std::vector<Error> errors;  // [references]
    double estimate = 0;        // of the relative error
    double last_estimate = 0, last_tets = 0;  // after the last step
    std::vector<double> last_relative;        // [references] of errors, after the last step
    double energy_changed = 0;  // by one split or merge (mean of a step's, largest of all steps), over the largest total energy
    double iterations = 0;      // CG, a step
    double changed = 0;         // splits and merges of a step over the tets of the front
    int troubled = 0;           // steps that did not converge or were rejected
    std::vector<double> step_milliseconds;  // [steps]
    std::vector<std::size_t> step_tets;     // [steps]
};

/// Every how many steps positions are compared. (Comparing visits all vertices of the tree, and the next step of a small
/// front would then start with cold caches, which costs it a fifth of its time.)
inline constexpr int compare_every = 4;

/// Called after each step (1, 2, ...) of each run; may look at the simulation, and takes no part in the times.
using SweepObserver = std::function<void(std::size_t run, int step, Simulation& simulation)>;

/// Advances all runs by `steps` and compares them with the first `references` of them, 1 <= references <= runs.size().
/// A run's model may have a deeper tree of the same roots than the others' (a finer reference): compared are the
/// vertices that all of them have. Memory: every run's state and 16 sets of positions per reference.
std::vector<SweepResult> sweep(const std::vector<SweepRun>& runs, std::size_t references, int steps,
                               const std::function<void(double fraction)>& progress = {}, const SweepObserver& observer = {});

/// Mean error against `reference` over time per step: a line for each order and budget along the tolerances, the finest
/// levels as points, the reference as a vertical rule. Runs without any error have no place on a logarithmic axis.
Chart speed_against_error(const std::string& title, const std::vector<SweepResult>& results, std::size_t reference);

/// "no budget", "at most 500 tets", "at most 5 ms a step", "at most 500 tets or 5 ms a step".
std::string describe_budget(const FrontSpec& front);

}  // namespace tetfront
