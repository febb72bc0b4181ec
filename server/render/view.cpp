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
    static_cast<ViewSpec&>(view) = spec;
    view.width = width, view.height = height;
    view.up = model.up;
    if (spec.fitted) fit_camera(view, model.rest_box, default_margin);
    view.fitted = false;
    view.floor = model.rest_box[static_cast<std::size_t>(model.up)];
    validate(view);
    return view;
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

View at_time(View view, double time) {
    const std::vector<CameraKey>& keys = view.keyframes;
    if (keys.empty()) return view;
    const auto next = static_cast<std::size_t>(
        std::ranges::upper_bound(keys, time, {}, [](const CameraKey& key) { return key.time; }) - keys.begin());
    if (next == 0 || next == keys.size()) {
        const CameraKey& key = next == 0 ? keys.front() : keys.back();
        view.eye = key.eye, view.target = key.target;
        return view;
    }
    const CameraKey &a = keys[next - 1], &b = keys[next];
    const CameraKey &before = keys[next >= 2 ? next - 2 : 0], &after = keys[std::min(next + 1, keys.size() - 1)];
    const double length = b.time - a.time, t = (time - a.time) / length;
    const auto curve = [&](Vec3 CameraKey::*what) -> Vec3 {  // cubic Hermite; slopes from the neighbours
        const Vec3 start = (b.*what - before.*what) / (b.time - before.time) * length;
        const Vec3 end = (after.*what - a.*what) / (after.time - a.time) * length;
        const double u = 1 - t;
        return (1 + 2 * t) * u * u * (a.*what) + t * u * u * start + t * t * (3 - 2 * t) * (b.*what) - t * t * u * end;
    };
    view.eye = curve(&CameraKey::eye), view.target = curve(&CameraKey::target);
    if ((view.eye - view.target).norm() < 1e-6) view.eye = a.eye, view.target = a.target;  // the curves may meet
    return view;
}

PixelBox covered(const Eigen::AlignedBox3f& box, const Eigen::Matrix4f& clip_from_world, int width, int height, int margin) {
    const PixelBox picture{0, 0, width, height};
    const Eigen::Array2f pixels(static_cast<float>(width), static_cast<float>(height));
    Eigen::AlignedBox2f seen;
    for (int i = 0; i < 8; ++i) {
        const Eigen::Vector4f clip =
            clip_from_world * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).homogeneous();
        if (!(clip[3] > 1e-6F)) return picture;
        const Eigen::Array2f at = (clip.head<2>().array() / clip[3] + 1) / 2 * pixels;
        seen.extend(at.max(-1e6F).min(1e6F).matrix());
    }
    const Eigen::Vector2i low = seen.min().array().floor().cast<int>(), high = seen.max().array().ceil().cast<int>();
    return common_part(picture, {low[0] - margin, low[1] - margin, high[0] - low[0] + 2 * margin, high[1] - low[1] + 2 * margin});
}

PixelBox common_part(const PixelBox& a, const PixelBox& b) {
    const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
    return {x, y, std::max(0, std::min(a.x + a.width, b.x + b.width) - x),
            std::max(0, std::min(a.y + a.height, b.y + b.height) - y)};
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
