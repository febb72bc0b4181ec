#include "server/render/visibility.hpp"

#include "server/render/shaders.hpp"
#include "server/render/visibility_shaders.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

namespace tetfront {

namespace {
constexpr int largest_side = 2048;
constexpr float reach_over_size = 0.14F;
const std::string version = shaders::version;

}  // namespace

Visibility::Visibility()
    : eye_("eye", version + shaders::cut_vertex + shaders::eye_vertex, version + shaders::eye_fragment),
      cut_eye_("cut eye", version + shaders::cut_vertex + shaders::eye_vertex,
               version + shaders::define_cut + shaders::cut_fragment + shaders::eye_fragment),
      visibility_("visibility", version + shaders::full_screen_vertex,
                  version + shaders::sampling + shaders::distance_of + shaders::visibility_fragment),
      blur_("visibility blur", version + shaders::full_screen_vertex,
            version + shaders::distance_of + shaders::visibility_blur_fragment) {}

void Visibility::draw(const FrameBuffers& buffers, const View& view, const Eigen::Matrix4f& clip_from_eye,
                      const Studio& studio, const Shadows& shadows, const Eigen::AlignedBox3f& box, float size) {
    const double scale = std::min(1.0, static_cast<double>(largest_side) / std::max(view.width, view.height));
    const int width = std::max(1, static_cast<int>(view.width * scale));
    const int height = std::max(1, static_cast<int>(view.height * scale));
    eye_normal_.allocate(width, height, GL_RGB10_A2, GL_NEAREST);
    eye_depth_.allocate(width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    for (GlTexture* texture : {&raw_, &half_blurred_}) texture->allocate(width, height, GL_RGBA8, GL_NEAREST);
    blurred_.allocate(width, height, GL_RGBA8, GL_LINEAR);

    // Nothing outside of the object's box is looked at, but for neighbours up to the blur's and the sky's reach: those
    // must say that nothing is there.
    const Eigen::Matrix4f eye = eye_from_world(view);
    const Eigen::Vector3f room = Eigen::Vector3f::Constant(0.02F * size);  // arrows are thicker than their axes
    const PixelBox seen = covered({box.min() - room, box.max() + room}, clip_from_eye * eye, width, height, 4);
    if (seen.empty()) return;
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    target_.bind(&eye_normal_, &eye_depth_);
    glClear(GL_DEPTH_BUFFER_BIT);
    const GlProgram& program = buffers.cut().isZero() ? eye_ : cut_eye_;
    program.use();
    program.set("eye_from_world", eye);
    program.set("clip_from_eye", clip_from_eye);
    if (&program == &cut_eye_) program.set("eye_position", Eigen::Vector3f(view.eye.cast<float>()));
    program.set("cut", buffers.cut());
    buffers.draw_surface();
    buffers.draw_arrows();

    glDisable(GL_DEPTH_TEST);
    glEnable(GL_SCISSOR_TEST);
    glScissor(seen.x, seen.y, seen.width, seen.height);
    nothing_.bind();
    const Eigen::Vector2f depth_row(clip_from_eye(2, 2), clip_from_eye(2, 3));
    target_.bind(&raw_, nullptr);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    visibility_.use();
    visibility_.set_texture("eye_normal", 0, GL_TEXTURE_2D, eye_normal_.id());
    visibility_.set_texture("eye_depth", 1, GL_TEXTURE_2D, eye_depth_.id());
    visibility_.set("depth_row", depth_row);
    visibility_.set("half_extent", Eigen::Vector2f(1 / clip_from_eye(0, 0), 1 / clip_from_eye(1, 1)));
    visibility_.set("reach", reach_over_size * size);
    visibility_.set("size", size);
    visibility_.set("key_light", Eigen::Vector3f(eye.topLeftCorner<3, 3>() * studio.key));
    shadows.bind_key(visibility_, 2, "light_from_eye", eye.inverse());
    glDrawArrays(GL_TRIANGLES, 0, 3);

    blur_.use();
    blur_.set_texture("eye_depth", 1, GL_TEXTURE_2D, eye_depth_.id());
    blur_.set("depth_row", depth_row);
    blur_.set("size", size);
    for (const bool second : {false, true}) {
        target_.bind(second ? &blurred_ : &half_blurred_, nullptr);
        blur_.set_texture("visibility", 0, GL_TEXTURE_2D, second ? half_blurred_.id() : raw_.id());
        blur_.set("axis", Eigen::Vector2i(second ? 0 : 1, second ? 1 : 0));
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace tetfront
