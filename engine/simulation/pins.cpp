#include "engine/simulation/pins.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "engine/simulation/pulls.hpp"

namespace tetfront {

std::uint64_t step_of(const TimelineEvent& event, double time_step) {
    return static_cast<std::uint64_t>(std::llround(event.time / time_step));
}

void Pins::hold(const Model& model, const std::vector<PinEdit>& edits, std::uint64_t steps, double time_step) {
    std::vector<Region> held;
    for (std::size_t i = 0; i < model.scene.pins.size(); ++i) {
        const auto released = [&](const TimelineEvent& e) {
            return e.release && static_cast<std::size_t>(*e.release) == i && step_of(e, time_step) <= steps;
        };
        if (std::ranges::none_of(model.scene.timeline, released)) held.push_back(model.scene.pins[i]);
    }
    std::vector<std::pair<Sphere, bool>> changes;
    for (const PinEdit& edit : edits) changes.push_back({{rest_position(model, edit.centre), edit.radius}, edit.pinned});
    any = false;
    for (VertexId v : ids<VertexId>(pinned.size())) {
        const Vec3& place = model.tree.rest(v);
        const bool by_scene = model.pinned[v] && std::ranges::any_of(held, [&](const Region& r) { return contains(r, place); });
        pinned[v] = by_scene ? at_rest : unpinned;
        for (const auto& [sphere, pin] : changes) {
            if (!contains(sphere, place)) continue;
            if (!pin) pinned[v] = unpinned;
            else if (!pinned[v]) pinned[v] = in_place;
        }
        any = any || pinned[v];
    }
    if (edits.empty()) {
        unresolved = model.unresolved;
        firm = model.held;
    } else {
        unresolved = find_unresolved(model.tree, pinned);
        firm = pins_hold(model.tree, pinned, model.size);
    }
}

PerTet<std::uint8_t> find_unresolved(const TetTree& tree, const PerVertex<std::uint8_t>& pinned) {
    PerTet<std::uint8_t> contains(tree.tet_count(), 0), unresolved(tree.tet_count(), 0);
    for (std::int64_t i = static_cast<std::int64_t>(tree.tet_count()) - 1; i >= 0; --i) {
        const TetId t(i);
        const auto is_pinned = [&](VertexId v) { return pinned[v] != 0; };
        const bool corners = std::ranges::any_of(tree.corners(t), is_pinned);
        bool below = false;
        if (!tree.is_leaf(t)) {
            const bool midpoints = std::ranges::any_of(tree.midpoints(t), is_pinned);
            for (TetId c : tree.children(t)) below = below || contains[c];
            below = below || midpoints;
        }
        contains[t] = corners || below;
        unresolved[t] = below && !corners;
    }
    return unresolved;
}

bool pins_hold(const TetTree& tree, const PerVertex<std::uint8_t>& pinned, double size) {
    Vec3 mean = Vec3::Zero();
    double count = 0;
    for (VertexId v : ids<VertexId>(tree.vertex_count())) {
        if (!pinned[v]) continue;
        mean += tree.rest(v);
        ++count;
    }
    if (count < 3) return false;
    mean /= count;
    Mat3 spread = Mat3::Zero();
    for (VertexId v : ids<VertexId>(tree.vertex_count()))
        if (pinned[v]) spread += (tree.rest(v) - mean) * (tree.rest(v) - mean).transpose() / count;
    const Vec3 squared = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();  // ascending
    return squared[1] > 1e-4 * size * size;  // one hundredth of the size across the line
}

}  // namespace tetfront
