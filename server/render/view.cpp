#include "server/render/view.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetfront {

namespace {

using Eigen::Vector3f;

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Room around the rest box for what the object will do. [share of the picture's half size]
constexpr double default_margin = 0.1;

Mat3 camera_axes(const View& view) {  // columns: right, up, backwards
    const Vec3 back = (view.eye - view.target).normalized();
    Vec3 up = Vec3::Unit(view.up);
    if (back.cross(up).norm() < 1e-4) up = Vec3::Unit((view.up + 1) % 3);  // straight from above or below
    const Vec3 right = up.cross(back).normalized();
    return (Mat3() << right, back.cross(right), back).finished();
}

template <class Number>
void check_range(const char* what, Number value, Number low, Number high) {
    if (!(value >= low && value <= high))
        throw InputError("view", what, "is " + std::to_string(value),
                         "use " + std::to_string(low) + " to " + std::to_string(high));
}

/// Seen from the front and a little from the right and above; the front is the broader horizontal side.
Vec3 default_direction(int up, const Vec3& extent) {
    // Horizontal axes so that (right, back, up) is right-handed: z up: x, -y; y up: x, z; x up: y, -z.
    const int right = up == 0 ? 1 : 0, depth = up == 2 ? 1 : 2;
    const double sign = up == 1 ? 1 : -1;
    const bool turn = extent[depth] > 1.3 * extent[right];
    const Vec3 broad = turn ? Vec3(Vec3::Unit(right)) : Vec3(sign * Vec3::Unit(depth));
    const Vec3 side = turn ? Vec3(-sign * Vec3::Unit(depth)) : Vec3(Vec3::Unit(right));
    return (broad + 0.42 * side + 0.38 * Vec3::Unit(up)).normalized();
}

}  // namespace

Colouring parse_colouring(const std::string& name) {
    if (name == "level") return Colouring::level;
    if (name == "stiffness") return Colouring::stiffness;
    throw InputError("view", "colouring", "is \"" + name + "\"", "use level or stiffness");
}

void validate(const View& view) {
    check_range("width", view.width, 16, 8192);
    check_range("height", view.height, 16, 8192);
    check_range("supersampling", view.supersampling, 1, 4);
    check_range("field_of_view", view.field_of_view, 5.0, 120.0);
    check_range("up", view.up, 0, 2);
    if (!view.eye.allFinite() || !view.target.allFinite() || !((view.eye - view.target).norm() > 1e-9))
        throw InputError("view", "eye", "is not a finite point apart from the target", "move the eye or the target");
}

View make_view(const ViewSpec& spec, const FrameModel& model, int width, int height) {
    View view;
    view.width = width, view.height = height;
    view.up = model.up;
    view.field_of_view = spec.field_of_view;
    view.colouring = parse_colouring(spec.colouring);
    view.wireframe = spec.wireframe;
    view.eye = spec.eye, view.target = spec.target;
    if (spec.fitted) fit_camera(view, model.rest_box, default_margin);
    view.floor = model.rest_box[static_cast<std::size_t>(model.up)];
    validate(view);
    return view;
}

std::optional<double> floor_height(const Model& model) {
    if (!model.has_pins) return std::nullopt;
    const auto& box = model.frame_model->rest_box;
    const auto up = static_cast<std::size_t>(model.frame_model->up);
    const double low = box[up], height = box[up + 3] - box[up];
    std::size_t lowest = 0, pinned = 0;
    for (const VertexId v : ids<VertexId>(model.tree.vertex_count())) {
        if (model.tree.rest(v)[model.frame_model->up] > low + height / 20) continue;
        ++lowest;
        pinned += model.pinned[v] ? 1 : 0;
    }
    return 2 * pinned >= lowest ? low : low - std::max(0.5 * height, 0.6 * model.size);
}

void fit_camera(View& view, const std::array<float, 6>& box, double margin) {
    const Vec3 low = Eigen::Map<const Vector3f>(box.data()).cast<double>();
    const Vec3 high = Eigen::Map<const Vector3f>(box.data() + 3).cast<double>();
    view.target = (low + high) / 2;
    const double radius = std::max((high - low).norm() / 2, 1e-9);
    view.eye = view.target + default_direction(view.up, high - low);
    const Mat3 axes = camera_axes(view);
    const double tan_y = std::tan(radians(view.field_of_view) / 2) * (1 - margin);
    const double tan_x = tan_y * view.width / view.height;
    // Every corner c must have |x| <= tan_x * depth and |y| <= tan_y * depth, with depth = distance - z.
    double distance = 0;
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
        const Vec3 c = axes.transpose() * (corner - view.target);
        distance = std::max({distance, c[2] + std::abs(c[0]) / tan_x, c[2] + std::abs(c[1]) / tan_y});
    }
    view.eye = view.target + axes.col(2) * std::max(distance, 1.05 * radius);
}

View turntable(View view, double turns) {
    const Eigen::AngleAxisd rotation(2 * std::numbers::pi * turns, Vec3::Unit(view.up));
    view.eye = view.target + rotation * (view.eye - view.target);
    return view;
}

Eigen::Matrix4f eye_from_world(const View& view) {
    const Mat3 axes = camera_axes(view);
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = axes.transpose();
    m.topRightCorner<3, 1>() = -axes.transpose() * view.eye;
    return m.cast<float>();
}

Eigen::Matrix4f clip_from_eye(const View& view, double n, double f) {
    const double y = 1 / std::tan(radians(view.field_of_view) / 2);
    Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
    m(0, 0) = y * view.height / view.width;
    m(1, 1) = y;
    m(2, 2) = (n + f) / (n - f);
    m(2, 3) = 2 * n * f / (n - f);
    m(3, 2) = -1;
    return m.cast<float>();
}

}  // namespace tetfront
