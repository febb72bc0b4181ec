#include "engine/simulation/ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetfront {

namespace {

/// Over the stiffness of a block of the tet's material, if all points of a tet were at the ground.
constexpr double ground_stiffness = 2;
/// Depth over the tet's size from which on it gets firm.
constexpr double ground_give = 0.1;
/// Sliding by less than this part of the object's size in a step counts as creep, and so does less than this part of the
/// depth: friction is never much stiffer than the ground, or the solver takes a thousand iterations.
constexpr double creep_over_size = 2e-5, creep_over_depth = 1.0 / 8;

/// On one edge of a triangle, whatever its size.
constexpr double most_points_along_edge = 256;

/// Along the axes and the diagonals, both ways.
std::array<Vec3, 14> directions() {
    std::array<Vec3, 14> all;
    std::size_t n = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (double sign : {-1.0, 1.0}) all[n++] = sign * Vec3::Unit(axis);
    for (double x : {-1.0, 1.0})
        for (double y : {-1.0, 1.0})
            for (double z : {-1.0, 1.0}) all[n++] = Vec3(x, y, z);
    return all;
}

/// The candidates that are farthest in some direction, ascending.
std::vector<std::uint32_t> outermost(const std::vector<std::uint32_t>& candidates, const std::vector<Vec3>& places) {
    static const std::array<Vec3, 14> all = directions();
    if (candidates.empty()) return {};
    std::vector<std::uint32_t> chosen;
    for (const Vec3& d : all) {
        chosen.push_back(*std::ranges::max_element(candidates, {}, [&](std::uint32_t v) { return d.dot(places[v]); }));
    }
    std::ranges::sort(chosen);
    chosen.erase(std::ranges::unique(chosen).begin(), chosen.end());
    return chosen;
}

/// [m] mean of the leaves.
double leaf_edge(const TetTree& tree) {
    double volume = 0;
    for (TetId t : tree.level(0)) volume += tree.volume(t);
    return std::cbrt(6 * volume / static_cast<double>(tree.tet_count(tree.depth())));
}

/// Points of the triangles that are larger than `spacing`, beside their corners: without them a flat face of few triangles would
/// rest on its corners alone.
SurfaceMesh points_inside_triangles(const SurfaceMesh& mesh, double spacing) {
    SurfaceMesh points;
    for (const auto& t : mesh.triangles) {
        std::array<Vec3, 3> corner;
        for (std::size_t i = 0; i < 3; ++i) corner[i] = mesh.positions[static_cast<std::size_t>(t[i])];
        const double longest = std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(), (corner[0] - corner[2]).norm()});
        const int n = static_cast<int>(std::min(std::ceil(longest / spacing), most_points_along_edge));
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; i + j <= n; ++j) {
                if (i == n || j == n || i + j == 0) continue;
                points.positions.emplace_back((i * corner[1] + j * corner[2] + (n - i - j) * corner[0]) / n);
            }
        }
    }
    return points;
}

}  // namespace

Ground::Ground(const GroundSpec& spec, int up, double size, const TetTree& tree, const Surface& surface)
    : spec_(spec), up_(up), size_(size), attachment_(surface.attachment) {
    SurfaceMesh inner = points_inside_triangles(surface.mesh, leaf_edge(tree));
    const std::vector<Attachment> more = embed(inner, tree).attachment;
    attachment_.insert(attachment_.end(), more.begin(), more.end());
    std::vector<Vec3> places = surface.mesh.positions;
    places.insert(places.end(), inner.positions.begin(), inner.positions.end());

    PerTet<std::vector<std::uint32_t>> chosen(tree.tet_count());
    for (std::size_t s = 0; s < attachment_.size(); ++s) chosen[attachment_[s].leaf].push_back(static_cast<std::uint32_t>(s));
    for (TetId t : tree.level(tree.depth())) chosen[t] = outermost(chosen[t], places);
    for (int level = tree.depth() - 1; level >= 0; --level) {
        for (TetId t : tree.level(level)) {
            std::vector<std::uint32_t> candidates;
            for (TetId c : tree.children(t)) candidates.insert(candidates.end(), chosen[c].begin(), chosen[c].end());
            chosen[t] = outermost(candidates, places);
        }
    }
    begin_.reserve(tree.tet_count() + 1);
    for (const std::vector<std::uint32_t>& of_tet : chosen) {
        begin_.push_back(static_cast<std::uint32_t>(vertices_.size()));
        vertices_.insert(vertices_.end(), of_tet.begin(), of_tet.end());
    }
    begin_.push_back(static_cast<std::uint32_t>(vertices_.size()));
}

void Ground::add_contacts(Loads& loads, const Front& front, const ElasticityMatrices& matrices, const State& state, double time_step) const {
    const Vec3 normal = Vec3::Unit(up_);
    const TetTree& tree = front.tree();
    const auto nodes = static_cast<std::size_t>(front.nodes_per_tet());
    for (TetId t : front.active()) {
        // Within the tet's own size of the ground, counting with the motion of two steps.
        const double edge = std::cbrt(6 * tree.volume(t));
        const auto& node = front.nodes(t);
        double lowest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < nodes; ++i) {
            const double height = state.x[node[i]][up_];
            lowest = std::min({lowest, height, height + 2 * time_step * state.v[node[i]][up_]});
        }
        if (lowest > spec_.height + edge / 2) continue;
        const auto add_points_of = [&](TetId part, double size) {
            const auto of_part = points(part);
            const double stiffness = ground_stiffness * matrices.elasticity[t](0, 0) * size / static_cast<double>(of_part.size());
            for (std::uint32_t s : of_part) {
                const Attachment& a = attachment_[s];
                PointContact contact{front.locate(a.leaf, a.barycentric), normal, spec_.height, stiffness, ground_give * size, spec_.friction, 0, 0};
                const double depth = contact.depth(value_at(contact.at, front.nodes_per_tet(), state.x));
                contact.pressing = contact.push(depth);
                contact.creep = std::max(creep_over_size * size_, creep_over_depth * spec_.friction * depth) / time_step;
                loads.contacts.push_back(contact);
            }
        };
        // A quadratic tet's faces bend between its corners.
        if (front.order() == 1) {
            add_points_of(t, edge);
        } else {
            for (TetId c : tree.children(t)) add_points_of(c, edge / 2);
        }
    }
}

}  // namespace tetfront
