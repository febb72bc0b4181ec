#pragma once
// The same scene on the finest front, beside the adaptive one: how far are the vertices apart, and what did it cost?
//
//     Comparison finest("finest-linear", model, 1);
//     StepReport report = simulation.step();
//     Comparison::Step step = finest.step(simulation);    // step.difference.mean, step.milliseconds

#include "engine/simulation/simulation.hpp"

#include <memory>
#include <string>
#include <vector>

namespace tetfront {

/// How far apart two sets of positions are, as in [Imai]: distances of vertices over the longest edge of the rest box.
struct Difference {
    double mean = 0, max = 0;
    double root_mean_square = 0;
};
/// Both must have the same size, > 0. longest_edge: [m].
Difference difference(const PerVertex<Vec3>& a, const PerVertex<Vec3>& b, double longest_edge);

/// All tets of the finest level that this order can have. order: 1 or 2. Throws InputError for order 2 without a level
/// below the roots.
FrontSpec finest_front(const Scene& scene, int order);

class Comparison {
 public:
    struct Step {
        double milliseconds = 0;
        Difference difference;  // of all finest vertices
        bool converged = true;
    };

    /// order: of the elements, 1 or 2. Throws as finest_front().
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
