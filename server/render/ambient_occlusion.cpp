#include "server/render/ambient_occlusion.hpp"

#include "server/render/shaders.hpp"

#include <algorithm>
#include <string>

namespace tetfront {

namespace {
constexpr int largest_side = 2048;
constexpr float reach_over_size = 0.14F;
const std::string version = shaders::version;
}  // namespace

AmbientOcclusion::AmbientOcclusion()
    : eye_("eye", version + shaders::eye_vertex, version + shaders::eye_fragment),
      occlusion_("occlusion", version + shaders::full_screen_vertex,
                 version + shaders::common + shaders::occlusion_fragment),
      blur_("occlusion blur", version + shaders::full_screen_vertex, version + shaders::occlusion_blur_fragment) {}

void AmbientOcclusion::draw(const FrameBuffers& buffers, const View& view, const Eigen::Matrix4f& clip_from_eye,
                            float size) {
    const double scale = std::min(1.0, static_cast<double>(largest_side) / std::max(view.width, view.height));
    const int width = std::max(1, static_cast<int>(view.width * scale));
    const int height = std::max(1, static_cast<int>(view.height * scale));
    eye_map_.allocate(width, height, GL_RGBA32F, GL_NEAREST);
    eye_depth_.allocate(width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    raw_.allocate(width, height, GL_R8, GL_NEAREST);
    blurred_.allocate(width, height, GL_R8, GL_LINEAR);

    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    target_.bind(&eye_map_, &eye_depth_);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    eye_.use();
    eye_.set("eye_from_world", eye_from_world(view));
    eye_.set("clip_from_eye", clip_from_eye);
    buffers.draw_surface();
    buffers.draw_arrows();

    glDisable(GL_DEPTH_TEST);
    nothing_.bind();
    target_.bind(&raw_, nullptr);
    occlusion_.use();
    occlusion_.set_texture("eye", 0, GL_TEXTURE_2D, eye_map_.id());
    occlusion_.set("half_extent", Eigen::Vector2f(1 / clip_from_eye(0, 0), 1 / clip_from_eye(1, 1)));
    occlusion_.set("reach", reach_over_size * size);
    occlusion_.set("size", size);
    glDrawArrays(GL_TRIANGLES, 0, 3);

    target_.bind(&blurred_, nullptr);
    blur_.use();
    blur_.set_texture("eye", 0, GL_TEXTURE_2D, eye_map_.id());
    blur_.set_texture("occlusion", 1, GL_TEXTURE_2D, raw_.id());
    blur_.set("size", size);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace tetfront
