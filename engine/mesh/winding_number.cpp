#include "engine/mesh/winding_number.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

namespace tetfront {

namespace {

constexpr std::int32_t leaf_size = 8;
/// A node is far when the point is this many radii away from its center. [Barill] section 3.4 uses 2.
constexpr double far_factor = 2.0;
/// Deep enough for any hierarchy over 2^31 triangles that halves at each level.
constexpr std::size_t stack_size = 64;

/// Solid angle of a triangle over 4 pi (Van Oosterom & Strackee 1983), positive when seen from its back.
double triangle_winding(const std::array<Vec3, 3>& triangle, const Vec3& p) {
    const Vec3 a = triangle[0] - p, b = triangle[1] - p, c = triangle[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double numerator = a.dot(b.cross(c));
    const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if (numerator == 0 && denominator <= 0) return 0;  // in the plane of the triangle: no side is right
    return std::atan2(numerator, denominator) / (2 * std::numbers::pi);
}

double squared_distance_to_box(const Vec3& p, const Vec3& low, const Vec3& high) {
    return (low - p).cwiseMax(p - high).cwiseMax(Vec3::Zero()).squaredNorm();
}

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double length2 = ab.squaredNorm();
    if (!(length2 > 0)) return a;
    return a + std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) * ab;
}

}  // namespace

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
    const double area2 = normal.squaredNorm();
    if (area2 > 0) {
        // Barycentric coordinates of the projection; inside all three edges the foot of the perpendicular is nearest.
        const Vec3 ap = p - a;
        const double v = ap.cross(ac).dot(normal) / area2, w = ab.cross(ap).dot(normal) / area2;
        if (v >= 0 && w >= 0 && v + w <= 1) return a + v * ab + w * ac;
    }
    Vec3 best = closest_on_segment(p, a, b);
    for (const Vec3& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)})
        if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
    return best;
}

SurfaceBvh::SurfaceBvh(const SurfaceMesh& mesh) {
    ENSURE(!mesh.triangles.empty(), "no triangles");
    ENSURE(mesh.triangles.size() < (std::size_t{1} << 31), "too many triangles: ", mesh.triangles.size());
    const std::size_t n = mesh.triangles.size();
    std::vector<Vec3> centroids(n);
    for (std::size_t t = 0; t < n; ++t) {
        centroids[t].setZero();
        for (std::int32_t v : mesh.triangles[t]) {
            ENSURE(v >= 0 && static_cast<std::size_t>(v) < mesh.positions.size(), "triangle ", t, " vertex ", v);
            centroids[t] += mesh.positions[static_cast<std::size_t>(v)] / 3;
        }
    }
    source_.resize(n);
    std::iota(source_.begin(), source_.end(), 0);
    triangles_.resize(n);
    for (std::size_t t = 0; t < n; ++t)
        for (std::size_t i = 0; i < 3; ++i)
            triangles_[t][i] = mesh.positions[static_cast<std::size_t>(mesh.triangles[t][i])];
    nodes_.reserve(2 * n / static_cast<std::size_t>(leaf_size) + 1);
    const std::vector<std::array<Vec3, 3>> unsorted = triangles_;
    // `build` sorts source_ first and reads triangles_ only through it, then the triangles follow.
    build(0, static_cast<std::int32_t>(n), centroids);
    for (std::size_t t = 0; t < n; ++t) triangles_[t] = unsorted[static_cast<std::size_t>(source_[t])];
}

std::int32_t SurfaceBvh::build(std::int32_t first, std::int32_t count, const std::vector<Vec3>& centroids) {
    const auto id = static_cast<std::int32_t>(nodes_.size());
    Node node;
    node.first = first;
    node.count = count;
    node.right = -1;
    node.low.setConstant(std::numeric_limits<double>::infinity());
    node.high = -node.low;
    node.dipole.setZero();
    node.first_moment.setZero();
    for (Mat3& m : node.second_moment) m.setZero();
    node.second_trace.setZero();
    Vec3 weighted = Vec3::Zero(), mean = Vec3::Zero(), centroid_low = node.low, centroid_high = node.high;
    double area = 0;
    const auto triangles = std::span(source_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    const auto area_normal = [&](std::int32_t t) -> Vec3 {
        const auto& x = triangles_[static_cast<std::size_t>(t)];
        return (x[1] - x[0]).cross(x[2] - x[0]) / 2;
    };
    for (std::int32_t t : triangles) {
        const Vec3& centroid = centroids[static_cast<std::size_t>(t)];
        for (const Vec3& x : triangles_[static_cast<std::size_t>(t)]) {
            node.low = node.low.cwiseMin(x);
            node.high = node.high.cwiseMax(x);
        }
        centroid_low = centroid_low.cwiseMin(centroid);
        centroid_high = centroid_high.cwiseMax(centroid);
        const Vec3 normal = area_normal(t);
        area += normal.norm();
        weighted += normal.norm() * centroid;
        mean += centroid / count;
        node.dipole += normal;
    }
    node.center = area > 0 ? Vec3(weighted / area) : mean;
    double radius2 = 0;
    for (std::int32_t t : triangles) {
        const Vec3 normal = area_normal(t);
        node.first_moment += normal * (centroids[static_cast<std::size_t>(t)] - node.center).transpose();
        Vec3 sum = Vec3::Zero();
        Mat3 products = Mat3::Zero();
        for (const Vec3& x : triangles_[static_cast<std::size_t>(t)]) {
            sum += x - node.center;
            products += (x - node.center) * (x - node.center).transpose();
        }
        products += sum * sum.transpose();  // / 12: mean of (x - center) x (x - center) over the triangle
        for (int i = 0; i < 3; ++i) node.second_moment[static_cast<std::size_t>(i)] += normal[i] / 24 * products;
        for (const Vec3& x : triangles_[static_cast<std::size_t>(t)])
            radius2 = std::max(radius2, (x - node.center).squaredNorm());
    }
    node.radius = std::sqrt(radius2);
    for (int i = 0; i < 3; ++i) {
        const Mat3& m = node.second_moment[static_cast<std::size_t>(i)];
        node.second_trace += 2 * m.row(i).transpose();
        node.second_trace[i] += m.trace();
    }
    nodes_.push_back(node);
    if (count <= leaf_size) return id;

    Eigen::Index axis = 0;
    (centroid_high - centroid_low).maxCoeff(&axis);
    const std::int32_t half = count / 2;
    std::nth_element(triangles.begin(), triangles.begin() + half, triangles.end(), [&](std::int32_t a, std::int32_t b) {
        const double xa = centroids[static_cast<std::size_t>(a)][axis],
                     xb = centroids[static_cast<std::size_t>(b)][axis];
        return xa < xb || (xa == xb && a < b);
    });
    build(first, half, centroids);
    const std::int32_t right = build(first + half, count - half, centroids);
    nodes_[static_cast<std::size_t>(id)].right = right;
    return id;
}

double SurfaceBvh::winding_number(const Vec3& p) const {
    double sum = 0;
    std::array<std::int32_t, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const std::int32_t id = stack[--top];
        const Node& node = nodes_[static_cast<std::size_t>(id)];
        const Vec3 r = node.center - p;
        const double r2 = r.squaredNorm();
        if (r2 > far_factor * far_factor * node.radius * node.radius) {
            // [Barill] section 3.2: Taylor series of r / |r|^3 about the node's center.
            const double r1 = std::sqrt(r2), r3 = r1 * r2;
            double cubic = 0;
            for (int i = 0; i < 3; ++i) cubic += r[i] * r.dot(node.second_moment[static_cast<std::size_t>(i)] * r);
            sum += (node.dipole.dot(r) + node.first_moment.trace() -
                    3 * (r.dot(node.first_moment * r) + r.dot(node.second_trace)) / r2 + 15 * cubic / (r2 * r2)) /
                   (4 * std::numbers::pi * r3);
        } else if (node.right < 0) {
            for (std::int32_t t = node.first; t < node.first + node.count; ++t)
                sum += triangle_winding(triangles_[static_cast<std::size_t>(t)], p);
        } else {
            stack[top++] = node.right;
            stack[top++] = id + 1;
        }
    }
    return sum;
}

double SurfaceBvh::exact_winding_number(const Vec3& p) const {
    double sum = 0;
    for (const auto& triangle : triangles_) sum += triangle_winding(triangle, p);
    return sum;
}

SurfaceBvh::Closest SurfaceBvh::closest(const Vec3& p, double limit) const {
    Closest best;
    double best2 = limit * limit;
    struct Entry {
        std::int32_t node;
        double distance2;
    };
    std::array<Entry, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = {0, squared_distance_to_box(p, nodes_[0].low, nodes_[0].high)};
    while (top > 0) {
        const Entry entry = stack[--top];
        if (!(entry.distance2 < best2)) continue;
        const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
        if (node.right < 0) {
            for (std::int32_t t = node.first; t < node.first + node.count; ++t) {
                const auto& x = triangles_[static_cast<std::size_t>(t)];
                const Vec3 point = closest_on_triangle(p, x[0], x[1], x[2]);
                const double distance2 = (point - p).squaredNorm();
                if (distance2 < best2) {
                    best2 = distance2;
                    best = {std::sqrt(distance2), point, source_[static_cast<std::size_t>(t)]};
                }
            }
            continue;
        }
        const auto distance2 = [&](std::int32_t child) {
            const Node& n = nodes_[static_cast<std::size_t>(child)];
            return squared_distance_to_box(p, n.low, n.high);
        };
        Entry near{entry.node + 1, distance2(entry.node + 1)}, far{node.right, distance2(node.right)};
        if (far.distance2 < near.distance2) std::swap(near, far);
        stack[top++] = far;
        stack[top++] = near;
    }
    return best;
}

}  // namespace tetfront
