#include "server/render/visibility.hpp"

#include "server/render/shaders.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

namespace tetfront {

namespace {
constexpr int largest_side = 2048;
constexpr float reach_over_size = 0.14F;
const std::string version = shaders::version;

/// Limits drawing to the pixels that the box may cover, plus a margin for the blur. All of them when the box reaches
/// behind the eye.
void limit_to(const Eigen::AlignedBox3f& box, const Eigen::Matrix4f& clip_from_world, int width, int height) {
    constexpr float margin = 4;
    const Eigen::Vector2f pixels(width, height);
    Eigen::AlignedBox2f seen;
    for (int i = 0; i < 8; ++i) {
        const Eigen::Vector4f clip =
            clip_from_world * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).homogeneous();
        if (!(clip[3] > 1e-6F)) return glDisable(GL_SCISSOR_TEST);
        const Eigen::Vector2f at = (clip.head<2>() / clip[3] + Eigen::Vector2f::Ones()) / 2;
        seen.extend(at.cwiseProduct(pixels).cwiseMax(-margin).cwiseMin(pixels + Eigen::Vector2f::Constant(margin)));
    }
    const Eigen::Vector2i low = (seen.min().array() - margin).floor().cast<int>();
    const Eigen::Vector2i high = (seen.max().array() + margin).ceil().cast<int>();
    glEnable(GL_SCISSOR_TEST);
    glScissor(low[0], low[1], high[0] - low[0], high[1] - low[1]);
}

}  // namespace

Visibility::Visibility()
    : eye_("eye", version + shaders::cut_vertex + shaders::eye_vertex,
           version + shaders::cut_fragment + shaders::eye_fragment),
      visibility_("visibility", version + shaders::full_screen_vertex,
                  version + shaders::common + shaders::visibility_fragment),
      blur_("visibility blur", version + shaders::full_screen_vertex, version + shaders::visibility_blur_fragment) {}

void Visibility::draw(const FrameBuffers& buffers, const View& view, const Eigen::Matrix4f& clip_from_eye,
                      const Studio& studio, const Shadows& shadows, const Eigen::AlignedBox3f& box, float size) {
    const double scale = std::min(1.0, static_cast<double>(largest_side) / std::max(view.width, view.height));
    const int width = std::max(1, static_cast<int>(view.width * scale));
    const int height = std::max(1, static_cast<int>(view.height * scale));
    eye_map_.allocate(width, height, GL_RGBA32F, GL_NEAREST);
    eye_depth_.allocate(width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    raw_.allocate(width, height, GL_RG8, GL_NEAREST);
    blurred_.allocate(width, height, GL_RG8, GL_LINEAR);

    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    const Eigen::Matrix4f eye = eye_from_world(view);
    target_.bind(&eye_map_, &eye_depth_);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    eye_.use();
    eye_.set("eye_from_world", eye);
    eye_.set("clip_from_eye", clip_from_eye);
    eye_.set("eye_position", Eigen::Vector3f(view.eye.cast<float>()));
    eye_.set("cut", buffers.cut());
    buffers.draw_surface();
    buffers.draw_arrows();

    glDisable(GL_DEPTH_TEST);
    nothing_.bind();
    // Only the passes over all pixels are limited: those near the border look at the eye map beyond it.
    const Eigen::Vector3f room = Eigen::Vector3f::Constant(0.02F * size);  // arrows are thicker than their axes
    limit_to({box.min() - room, box.max() + room}, clip_from_eye * eye, width, height);
    target_.bind(&raw_, nullptr);
    visibility_.use();
    visibility_.set_texture("eye", 0, GL_TEXTURE_2D, eye_map_.id());
    visibility_.set("half_extent", Eigen::Vector2f(1 / clip_from_eye(0, 0), 1 / clip_from_eye(1, 1)));
    visibility_.set("reach", reach_over_size * size);
    visibility_.set("size", size);
    visibility_.set("key_light", Eigen::Vector3f(eye.topLeftCorner<3, 3>() * studio.key));
    shadows.bind_key(visibility_, 1, "light_from_eye", eye.inverse());
    glDrawArrays(GL_TRIANGLES, 0, 3);

    target_.bind(&blurred_, nullptr);
    blur_.use();
    blur_.set_texture("eye", 0, GL_TEXTURE_2D, eye_map_.id());
    blur_.set_texture("visibility", 1, GL_TEXTURE_2D, raw_.id());
    blur_.set("size", size);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace tetfront
