#include "engine/simulation/pulls.hpp"

#include <cmath>

#include "engine/base/error.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace {

/// A pull acts as if never longer than this part of the object's size ...
constexpr double pull_reach = 0.5;
/// ... and then accelerates the object as a whole with this [m/s^2].
constexpr double pull_acceleration = 50;

void check_target(const Vec3& target) {
    if (!target.allFinite() || target.cwiseAbs().maxCoeff() > 1e9)
        throw InputError("", "/target", "is not a position", "use three finite numbers within 1e9 m");
}

PointSpring spring_of(const Pull& pull, const Front& front, const Model& model, const PerVertex<Vec3>& x) {
    PointSpring spring{front.locate(pull.at.leaf, pull.at.barycentric), pull.target, 0, 0};
    const Vec3 from = value_at(spring.at, front.nodes_per_tet(), x), reach = pull.target - from;
    const double longest = pull_reach * model.size;
    spring.stiffness = model.mass * pull_acceleration / longest;
    spring.damping = 2 * std::sqrt(spring.stiffness * model.mass);
    if (reach.norm() > longest) spring.target = from + reach * (longest / reach.norm());
    return spring;
}

}  // namespace

Vec3 rest_position(const Model& model, const SurfacePoint& point) {
    const auto& triangles = model.surface.mesh.triangles;
    if (point.triangle >= triangles.size()) {
        throw InputError("", "/triangle", "is " + std::to_string(point.triangle), "use 0.." + std::to_string(triangles.size() - 1));
    }
    const Vec3& b = point.barycentric;
    if (!b.allFinite() || b.minCoeff() < -1e-9 || std::abs(b.sum() - 1) > 1e-3)
        throw InputError("", "/barycentric", "is not a point of the triangle", "use three numbers >= 0 with sum 1");
    Vec3 rest = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
        rest += b[i] * model.surface.mesh.positions[static_cast<std::size_t>(triangles[point.triangle][static_cast<std::size_t>(i)])];
    return rest;
}

Attachment attach(const Model& model, const SurfacePoint& point) {
    const Vec3 rest = rest_position(model, point);
    // The point takes the leaf of its nearest corner: at most about one leaf away from it.
    int nearest = 0;
    point.barycentric.maxCoeff(&nearest);
    const auto vertex = model.surface.mesh.triangles[point.triangle][static_cast<std::size_t>(nearest)];
    const TetId leaf = model.surface.attachment[static_cast<std::size_t>(vertex)].leaf;
    const TetTree& tree = model.tree;
    const auto& c = tree.corners(leaf);
    const auto g = barycentric_gradients({tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3])});
    Attachment at{leaf, Vec4::Zero()};
    const Vec3 d = rest - tree.rest(c[0]);
    for (int k = 0; k < 3; ++k) at.barycentric[k + 1] = g(k, 0) * d[0] + g(k, 1) * d[1] + g(k, 2) * d[2];
    at.barycentric[0] = 1 - at.barycentric.tail<3>().sum();
    return at;
}

void Pulls::begin(std::uint64_t id, const Model& model, const SurfacePoint& point, const Vec3& target) {
    const Attachment at = attach(model, point);
    check_target(target);
    pulls_[id] = {at, target};
}

void Pulls::move(std::uint64_t id, const Vec3& target) {
    check_target(target);
    const auto it = pulls_.find(id);
    if (it != pulls_.end()) it->second.target = target;
}

void Pulls::add_to(Loads& loads, const Front& front, const Model& model, const PerVertex<Vec3>& x) const {
    for (const auto& [id, pull] : pulls_) loads.springs.push_back(spring_of(pull, front, model, x));
}

std::vector<FramePull> Pulls::seen(const Front& front, const Model& model, const PerVertex<Vec3>& x) const {
    std::vector<FramePull> result;
    for (const auto& [id, pull] : pulls_) {
        const PointSpring spring = spring_of(pull, front, model, x);
        const Vec3 from = value_at(spring.at, front.nodes_per_tet(), x);
        FramePull seen;
        for (int c = 0; c < 3; ++c) {
            seen.from[static_cast<std::size_t>(c)] = static_cast<float>(from[c]);
            seen.to[static_cast<std::size_t>(c)] = static_cast<float>(pull.target[c]);
        }
        seen.force = static_cast<float>(spring.stiffness * (spring.target - from).norm());
        result.push_back(seen);
    }
    return result;
}

}  // namespace tetfront
