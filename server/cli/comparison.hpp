#pragma once
// The same scene on the finest front, beside the adaptive one: how far are the vertices apart, and what did it cost?
//
//     Comparison finest("finest-linear", model, 1);
//     StepReport report = simulation.step();
//     Comparison::Step step = finest.step(simulation);    // step.error_mean, step.milliseconds

#include "engine/simulation/simulation.hpp"

#include <memory>
#include <string>
#include <vector>

namespace tetfront {

class Comparison {
 public:
    struct Step {
        double milliseconds = 0;
        double error_mean = 0, error_max = 0;  // distance of all finest vertices over the longest edge of the rest box
        bool converged = true;
    };

    /// order: of the elements, 1 or 2. Throws InputError for order 2 without a level below the roots.
    Comparison(std::string name, std::shared_ptr<const Model> model, int order);

    /// One step of the finest front, then the distance between both. The other simulation has the same tree and has
    /// made the same number of steps.
    Step step(const Simulation& other);

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] const FrontSpec& front() const { return front_; }
    [[nodiscard]] std::size_t tets() const { return simulation_.model().tree.tet_count(front_.max_level); }

 private:
    std::string name_;
    FrontSpec front_;
    Simulation simulation_;
};

/// "finest", "finest-linear" or "finest-quadratic" -> order; `scene_order` for "finest". Throws InputError.
int comparison_order(const std::string& name, int scene_order);

}  // namespace tetfront
