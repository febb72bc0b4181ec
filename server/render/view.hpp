#pragma once
// What to see of a frame, and from where: the scene's ViewSpec, made into a camera for a picture of some size.
//
//     View view = make_view(scene.view, *frame.model, 1920, 1080);     // fits the camera when the scene says nothing
//     Image image = renderer.render(frame, turntable(view, 0.25), {"Bunny"});
//
// Axes are the scene's; `up` says which of them points up.

#include "engine/scene/scene.hpp"
#include "engine/simulation/simulation.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>

namespace tetfront {

/// The shared description with what only pictures have. A camera that is still to be fitted: see make_view().
struct View : ViewSpec {
    int up = 2;                      // axis: 0 x, 1 y, 2 z
    int width = 1280, height = 720;  // [pixels] each 16..8192
    int supersampling = 2;           // 1..4: samples along each side of a pixel
    /// [m] height (coordinate along `up`) of the floor that takes the shadow; none: nothing does.
    std::optional<double> floor;
};

/// Throws InputError that names the first field out of its range.
void validate(const View& view);

/// The view that a scene asks for. A fitted camera looks slightly down onto the broader side of the rest box and sees
/// all of it, with room to move. The floor touches the rest box from below.
View make_view(const ViewSpec& spec, const FrameModel& model, int width, int height);

/// Eye and target such that the box (low xyz, high xyz) is inside of the picture with a margin on all sides.
/// margin: share of the picture's half height and half width that stays free, 0..0.9.
void fit_camera(View& view, const std::array<float, 6>& box, double margin);

/// The same camera, turned about the up axis through the target; turns: 1 is a full revolution, counter-clockwise seen
/// from above.
View turntable(View view, double turns);

/// The camera at a moment [s]: on a smooth curve (Catmull & Rom 1974, with the keys' times) through the view's
/// keyframes; before the first and after the last it stands still. Without keyframes: the same view.
View at_time(View view, double time);

/// Part of a picture in pixels, or of its samples; y counts from the bottom, as in GL.
struct PixelBox {
    int x = 0, y = 0, width = 0, height = 0;
    [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
};
/// The part of a picture of this size that the box may cover, with `margin` pixels around; all of the picture when the
/// box reaches behind the eye.
PixelBox covered(const Eigen::AlignedBox3f& box, const Eigen::Matrix4f& clip_from_world, int width, int height, int margin);
PixelBox common_part(const PixelBox& a, const PixelBox& b);

/// World -> eye space (x right, y up, looking along -z).
Eigen::Matrix4f eye_from_world(const View& view);
/// Eye space -> clip space of the whole picture; near and far [m] > 0.
Eigen::Matrix4f clip_from_eye(const View& view, double near_plane, double far_plane);

}  // namespace tetfront
