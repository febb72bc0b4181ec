#include "server/cli/comparison.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetfront {

Difference difference(const PerVertex<Vec3>& a, const PerVertex<Vec3>& b, double longest_edge) {
    ENSURE(a.size() == b.size() && !a.empty(), "the trees differ: ", a.size(), ' ', b.size());
    double sum = 0, squares = 0, largest = 0;
    for (const VertexId v : ids<VertexId>(a.size())) {
        const double distance = (a[v] - b[v]).norm();
        sum += distance;
        squares += distance * distance;
        largest = std::max(largest, distance);
    }
    const double count = static_cast<double>(a.size());
    return {sum / count / longest_edge, largest / longest_edge, std::sqrt(squares / count) / longest_edge};
}

FrontSpec finest_front(const Scene& scene, int order) {
    const int level = order == 2 ? scene.levels - 1 : scene.levels;
    if (level < 0)
        throw InputError(scene.file.string(), "/levels", "is 0, and quadratic tets need one level below them",
                         "use levels >= 1, or linear tets only");
    FrontSpec front = scene.front;
    front.order = order;
    front.min_level = front.max_level = level;
    return front;
}

Comparison::Comparison(std::string name, std::shared_ptr<const Model> model, int order)
    : name_(std::move(name)), front_(finest_front(model->scene, order)), simulation_(std::move(model), front_) {}

Comparison::Step Comparison::step(const Simulation& other) {
    const StepReport report = simulation_.step();
    return {.milliseconds = report.milliseconds.total(),
            .difference = difference(simulation_.all_positions(), other.all_positions(), simulation_.model().size),
            .converged = report.converged};
}

int comparison_order(const std::string& name, int scene_order) {
    if (name == "finest") return scene_order;
    if (name == "finest-linear") return 1;
    if (name == "finest-quadratic") return 2;
    throw InputError("--compare", name, "is not known", "use finest, finest-linear or finest-quadratic");
}

}  // namespace tetfront
