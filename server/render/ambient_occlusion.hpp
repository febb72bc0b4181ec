#pragma once
// How much of the surroundings each visible point of the object sees, as a texture of the whole picture.
//
//     occlusion.draw(buffers, view, clip_from_eye, size);
//     program.set_texture("occlusion", 1, GL_TEXTURE_2D, occlusion.texture());     // R: 1 open .. 0 hidden
//
// Computed at the picture's own resolution (at most 2048 a side, it is smooth), not per sample.

#include "server/render/frame_buffers.hpp"
#include "server/render/gl.hpp"

namespace tetfront {

class AmbientOcclusion {
 public:
    AmbientOcclusion();

    /// clip_from_eye: of the whole picture. size [m]: scales the reach.
    void draw(const FrameBuffers& buffers, const View& view, const Eigen::Matrix4f& clip_from_eye, float size);
    [[nodiscard]] GLuint texture() const { return blurred_.id(); }

 private:
    GlProgram eye_, occlusion_, blur_;
    GlVertexArray nothing_;
    GlFramebuffer target_;
    GlTexture eye_map_, eye_depth_, raw_, blurred_;
};

}  // namespace tetfront
