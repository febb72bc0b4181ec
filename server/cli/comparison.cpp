#include "server/cli/comparison.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <utility>

namespace tetfront {

namespace {

FrontSpec finest_front(const Scene& scene, int order) {
    const int level = order == 2 ? scene.levels - 1 : scene.levels;
    if (level < 0)
        throw InputError(scene.file.string(), "/levels", "is 0, and quadratic tets need one level below them",
                         "use levels >= 1, or --compare finest-linear");
    FrontSpec front = scene.front;
    front.order = order;
    front.min_level = front.max_level = level;
    return front;
}

}  // namespace

Comparison::Comparison(std::string name, std::shared_ptr<const Model> model, int order)
    : name_(std::move(name)), front_(finest_front(model->scene, order)), simulation_(std::move(model), front_) {}

Comparison::Step Comparison::step(const Simulation& other) {
    const StepReport report = simulation_.step();
    const PerVertex<Vec3> mine = simulation_.all_positions(), theirs = other.all_positions();
    ENSURE(mine.size() == theirs.size(), "the trees differ: ", mine.size(), ' ', theirs.size());
    Step result{.milliseconds = report.milliseconds.total(), .converged = report.converged};
    double sum = 0, largest = 0;
    for (const VertexId v : ids<VertexId>(mine.size())) {
        const double distance = (mine[v] - theirs[v]).norm();
        sum += distance;
        largest = std::max(largest, distance);
    }
    const double longest_edge = simulation_.model().size;
    result.error_mean = sum / static_cast<double>(mine.size()) / longest_edge;
    result.error_max = largest / longest_edge;
    return result;
}

int comparison_order(const std::string& name, int scene_order) {
    if (name == "finest") return scene_order;
    if (name == "finest-linear") return 1;
    if (name == "finest-quadratic") return 2;
    throw InputError("--compare", name, "is not known", "use finest, finest-linear or finest-quadratic");
}

}  // namespace tetfront
