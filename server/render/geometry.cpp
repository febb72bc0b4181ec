#include "server/render/geometry.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetfront {

namespace {

using Eigen::Vector3f;

Vector3f vector(const Point& p) { return {p[0], p[1], p[2]}; }
Point point(const Vector3f& v) { return {v[0], v[1], v[2]}; }

/// A surface of revolution about `axis` through `origin`: `profile` holds distance along and from the axis, and the
/// normal's components in the same frame.
struct ProfilePoint {
    float along, radius, normal_along, normal_out;
};
void append_revolution(Solid& solid, const Vector3f& origin, const Vector3f& axis,
                       std::span<const ProfilePoint> profile) {
    constexpr std::uint32_t sides = 24;
    const Vector3f u = axis.unitOrthogonal(), v = axis.cross(u);
    const auto first = static_cast<std::uint32_t>(solid.positions.size());
    for (const ProfilePoint& p : profile) {
        for (std::uint32_t i = 0; i < sides; ++i) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / sides;
            const Vector3f out = u * std::cos(angle) + v * std::sin(angle);
            solid.positions.push_back(point(origin + axis * p.along + out * p.radius));
            solid.normals.push_back(point((axis * p.normal_along + out * p.normal_out).normalized()));
        }
    }
    for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
        for (std::uint32_t i = 0; i < sides; ++i) {
            const std::uint32_t a = first + ring * sides + i, b = first + ring * sides + (i + 1) % sides;
            solid.triangles.push_back({a, b, b + sides});
            solid.triangles.push_back({a, b + sides, a + sides});
        }
    }
}

void append_ball(Solid& solid, const Vector3f& centre, float radius) {
    std::array<ProfilePoint, 13> profile;
    for (std::size_t i = 0; i < profile.size(); ++i) {
        const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / (profile.size() - 1);
        const float c = -std::cos(angle), s = std::sin(angle);
        profile[i] = {radius * c, radius * s, c, s};
    }
    append_revolution(solid, centre, Vector3f::UnitZ(), profile);
}

}  // namespace

VertexFaces::VertexFaces(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t vertex_count)
    : begin_(vertex_count + 1), corners_(3 * triangles.size()) {
    for (const auto& triangle : triangles) {
        for (const std::uint32_t v : triangle) {
            ENSURE(v < vertex_count, "triangle corner ", v, " of ", vertex_count, " surface vertices");
            ++begin_[v + 1];
        }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) begin_[v + 1] += begin_[v];
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (const auto& t : triangles) {
        for (std::size_t i = 0; i < 3; ++i) corners_[next[t[i]]++] = {t[(i + 1) % 3], t[(i + 2) % 3]};
    }
}

void VertexFaces::normals(std::span<const Point> positions, std::vector<Point>& out) const {
    ENSURE(positions.size() + 1 == begin_.size(), positions.size(), " positions, made for ", begin_.size() - 1);
    out.resize(positions.size());
    parallel_for(positions.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vector3f x = vector(positions[v]);
            Vector3f sum = Vector3f::Zero();
            for (std::uint32_t i = begin_[v]; i < begin_[v + 1]; ++i) {
                const Vector3f a = vector(positions[corners_[i].next]) - x, b = vector(positions[corners_[i].last]) - x;
                const float weight = a.squaredNorm() * b.squaredNorm();
                if (weight > 0) sum += a.cross(b) / weight;
            }
            const float length = sum.norm();
            out[v] = length > 0 && std::isfinite(length) ? point(sum / length) : Point{0, 0, 1};
        }
    });
}

bool is_closed(std::span<const std::array<std::uint32_t, 3>> triangles) {
    std::vector<std::uint64_t> edges, opposite;  // from << 32 | to
    for (const auto& t : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint64_t a = t[i], b = t[(i + 1) % 3];
            edges.push_back(a << 32 | b), opposite.push_back(b << 32 | a);
        }
    }
    std::ranges::sort(edges), std::ranges::sort(opposite);
    return std::ranges::adjacent_find(edges) == edges.end() && edges == opposite;
}

std::vector<std::array<std::uint8_t, 4>> surface_colours(const Frame& frame, const View& view) {
    std::vector<std::array<std::uint8_t, 4>> colours;
    colours.reserve(frame.surface.size());
    const auto add = [&colours](Rgb c) { colours.push_back({c.r, c.g, c.b, 255}); };
    if (view.colouring == Colouring::level) {
        for (const std::uint8_t level : frame.topology->surface_level) add(level_colour(level));
        return colours;
    }
    const ColourScale scale = colour_scale(frame, view);
    for (const float value : view.colouring == Colouring::stiffness ? frame.model->young : frame.field_values)
        add(scale.colour(static_cast<double>(value)));
    return colours;
}

Point force_tip(const FrameModel& model, const FrameForce& force) {
    const auto& box = model.rest_box;
    const float radius = 0.5F * (Vector3f(box[3], box[4], box[5]) - Vector3f(box[0], box[1], box[2])).norm();
    const float newtons_per_metre = 0.1F * model.young_range[0] * radius;
    Vector3f way = vector(force.value) / newtons_per_metre;
    if (!way.allFinite()) return force.at;
    const float length = way.norm();
    if (length > 0) way *= std::clamp(length, 0.33F * radius, 1.5F * radius) / length;
    return point(vector(force.at) + way);
}

Eigen::AlignedBox3f bounds(const Frame& frame, bool with_front, bool with_arrows) {
    Eigen::AlignedBox3f box;
    const auto extend = [&box](const Point& p) {
        const Vector3f v = vector(p);
        if (v.allFinite()) box.extend(v);
    };
    for (const Point& p : frame.surface) extend(p);
    if (with_front) {
        for (const Point& p : frame.front_positions) extend(p);
    }
    if (with_arrows) {
        for (const FramePull& pull : frame.pulls) extend(pull.from), extend(pull.to);
        for (const FrameForce& force : frame.forces) extend(force.at), extend(force_tip(*frame.model, force));
    }
    if (box.isEmpty()) return {Vector3f::Constant(-0.5F), Vector3f::Constant(0.5F)};
    return box;
}

void append_arrow(Solid& solid, const Point& from, const Point& to, float radius) {
    const Vector3f start = vector(from), way = vector(to) - start;
    if (!start.allFinite() || !way.allFinite()) return;
    append_ball(solid, start, 1.9F * radius);
    const float length = way.norm();
    if (length < 1e-3F * radius) return;
    const float head = std::min(7 * radius, length), neck = length - head, wide = head * 0.36F;
    const float slope = 1 / std::hypot(head, wide);
    const float thin = std::min(radius, wide / 2);  // of a short arrow, so that its head stays the widest
    const std::array<ProfilePoint, 2> shaft = {{{0, thin, 0, 1}, {neck, thin, 0, 1}}};
    const std::array<ProfilePoint, 2> base = {{{neck, thin, -1, 0}, {neck, wide, -1, 0}}};
    const std::array<ProfilePoint, 2> cone = {
        {{neck, wide, wide * slope, head * slope}, {length, 0, wide * slope, head * slope}}};
    append_revolution(solid, start, way / length, shaft);
    append_revolution(solid, start, way / length, base);
    append_revolution(solid, start, way / length, cone);
}

}  // namespace tetfront
