#include "engine/tree/surface.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mesh/winding_number.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace tetfront {

namespace {

/// A barycentric coordinate this far below 0 still counts as inside: rounding, not geometry.
constexpr double tolerance = 1e-9;
constexpr std::int32_t leaf_size = 4;

Vec4 barycentric_of(const TetTree& tree, TetId t, const Vec3& p) {
    const auto& c = tree.corners(t);
    const Vec3& origin = tree.rest(c[0]);
    Mat3 edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = tree.rest(c[static_cast<std::size_t>(i + 1)]) - origin;
    const Vec3 b = edges.inverse() * (p - origin);
    return {1 - b.sum(), b[0], b[1], b[2]};
}

/// Finds the root tet that a point is in, or the nearest one: a hierarchy of the roots' boxes.
class RootLocator {
 public:
    struct Hit {
        TetId root;
        Vec3 point;           // of the root, nearest to the question's
        double distance = 0;  // [m] 0 inside
    };

    explicit RootLocator(const TetTree& tree) : tree_(tree), order_(tree.root_count()) {
        std::iota(order_.begin(), order_.end(), 0);
        std::vector<Box> boxes;
        for (TetId t : tree.level(0)) {
            Box box;
            for (VertexId v : tree.corners(t)) box.extend(tree.rest(v));
            boxes.push_back(box);
        }
        build(0, static_cast<std::int32_t>(order_.size()), boxes);
    }

    [[nodiscard]] Hit find(const Vec3& p) const {
        Hit best;
        double best2 = std::numeric_limits<double>::infinity();
        std::array<std::pair<std::int32_t, double>, 64> stack;
        std::size_t top = 0;
        stack[top++] = {0, nodes_[0].box.squared_distance(p)};
        while (top > 0 && best2 > 0) {
            const auto [id, distance2] = stack[--top];
            if (distance2 > best2) continue;
            const Node& node = nodes_[static_cast<std::size_t>(id)];
            if (node.right >= 0) {
                std::pair near{id + 1, nodes_[static_cast<std::size_t>(id) + 1].box.squared_distance(p)};
                std::pair far{node.right, nodes_[static_cast<std::size_t>(node.right)].box.squared_distance(p)};
                if (far.second < near.second) std::swap(near, far);
                stack[top++] = far;
                stack[top++] = near;
                continue;
            }
            for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
                const TetId root(order_[static_cast<std::size_t>(i)]);
                const Vec3 nearest = nearest_point(root, p);
                const double squared = (nearest - p).squaredNorm();
                if (squared < best2) {
                    best2 = squared;
                    best = {root, nearest, std::sqrt(squared)};
                }
            }
        }
        return best;
    }

 private:
    struct Box {
        Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
        void extend(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
        [[nodiscard]] double squared_distance(const Vec3& p) const {
            return (low - p).cwiseMax(p - high).cwiseMax(Vec3::Zero()).squaredNorm();
        }
    };
    struct Node {
        Box box;
        std::int32_t first, count, right;  // right: second child, the first is the next node; -1: leaf
    };

    std::int32_t build(std::int32_t first, std::int32_t count, const std::vector<Box>& boxes) {
        const auto id = static_cast<std::int32_t>(nodes_.size());
        Box box, centers;
        const auto part = std::span(order_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
        for (std::int32_t t : part) {
            const Box& b = boxes[static_cast<std::size_t>(t)];
            box.extend(b.low), box.extend(b.high);
            centers.extend((b.low + b.high) / 2);
        }
        nodes_.push_back({box, first, count, -1});
        if (count <= leaf_size) return id;
        Eigen::Index axis = 0;
        (centers.high - centers.low).maxCoeff(&axis);
        const auto key = [&](std::int32_t t) {
            const Box& b = boxes[static_cast<std::size_t>(t)];
            return std::pair(b.low[axis] + b.high[axis], t);
        };
        const std::int32_t half = count / 2;
        std::nth_element(part.begin(), part.begin() + half, part.end(),
                         [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
        build(first, half, boxes);
        const std::int32_t right = build(first + half, count - half, boxes);
        nodes_[static_cast<std::size_t>(id)].right = right;
        return id;
    }

    [[nodiscard]] Vec3 nearest_point(TetId root, const Vec3& p) const {
        if (barycentric_of(tree_, root, p).minCoeff() >= -tolerance) return p;
        const auto& c = tree_.corners(root);
        const auto x = [&](std::size_t i) -> const Vec3& { return tree_.rest(c[i]); };
        Vec3 best = x(0);
        for (const auto& face : {std::array{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}) {
            const Vec3 q =
                closest_on_triangle(p, x(static_cast<std::size_t>(face[0])), x(static_cast<std::size_t>(face[1])),
                                    x(static_cast<std::size_t>(face[2])));
            if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
        }
        return best;
    }

    const TetTree& tree_;
    std::vector<std::int32_t> order_;  // [roots]
    std::vector<Node> nodes_;
};

/// Barycentric coordinates in each child of a point given by those in the parent: inverse of barycentric_in_parent.
std::array<Eigen::Matrix4d, 8> child_maps() {
    std::array<Eigen::Matrix4d, 8> maps;
    for (int child = 0; child < 8; ++child) {
        Eigen::Matrix4d to_parent;
        for (int i = 0; i < 4; ++i) to_parent.col(i) = barycentric_in_parent(child, Vec4::Unit(i));
        maps[static_cast<std::size_t>(child)] = to_parent.inverse();
    }
    return maps;
}

/// The leaf below `root` that has the point, by its barycentric coordinates in the root.
TetId descend(const TetTree& tree, TetId root, Vec4 barycentric) {
    static const std::array<Eigen::Matrix4d, 8> maps = child_maps();
    TetId tet = root;
    for (int level = 0; level < tree.depth(); ++level) {
        int best = 0;
        Vec4 in_best = Vec4::Constant(-std::numeric_limits<double>::infinity());
        for (int child = 0; child < 8; ++child) {
            const Vec4 b = maps[static_cast<std::size_t>(child)] * barycentric;
            if (b.minCoeff() > in_best.minCoeff()) {
                best = child;
                in_best = b;
            }
        }
        tet = *(tree.children(tet).begin() + best);
        barycentric = in_best;
    }
    return tet;
}

}  // namespace

Surface embed(SurfaceMesh mesh, const TetTree& tree) {
    const RootLocator locator(tree);
    Surface surface;
    surface.attachment.resize(mesh.positions.size());
    std::vector<double> distance(mesh.positions.size(), 0.0);
    parallel_for(mesh.positions.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3& p = mesh.positions[v];
            ENSURE(p.allFinite(), "surface vertex ", v, " is not finite");
            const RootLocator::Hit hit = locator.find(p);
            // An outside vertex takes the leaf at its nearest point: neighbours on the surface get neighbouring leaves.
            const TetId leaf = descend(tree, hit.root, barycentric_of(tree, hit.root, hit.point));
            Vec4 b = barycentric_of(tree, leaf, p);
            if (hit.distance == 0) {
                b = b.cwiseMax(0.0);
                b /= b.sum();
            }
            surface.attachment[v] = {leaf, b};
            distance[v] = hit.distance;
        }
    });
    for (double d : distance) {
        if (d > 0) ++surface.outside_count;
        surface.outside_distance = std::max(surface.outside_distance, d);
    }
    surface.mesh = std::move(mesh);
    return surface;
}

}  // namespace tetfront
