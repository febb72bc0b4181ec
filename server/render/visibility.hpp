#pragma once
// How much of the sky and of the key light each visible point of the object sees, as a texture of the whole picture.
//
//     visibility.draw(buffers, view, clip_from_eye, studio, shadows, box, size);
//     program.set_texture("visibility", 0, GL_TEXTURE_2D, visibility.texture());     // R sky, G key light: 0..1
//
// Computed at the picture's own resolution (at most 2048 a side: it is smooth), not per sample, and only where the
// object's box is; elsewhere the texture holds anything.

#include "server/render/frame_buffers.hpp"
#include "server/render/gl.hpp"
#include "server/render/shadows.hpp"

namespace tetfront {

class Visibility {
 public:
    Visibility();

    /// clip_from_eye: of the whole picture. box: of everything solid. size [m]: scales the reach.
    void draw(const FrameBuffers& buffers, const View& view, const Eigen::Matrix4f& clip_from_eye, const Studio& studio,
              const Shadows& shadows, const Eigen::AlignedBox3f& box, float size);
    [[nodiscard]] GLuint texture() const { return blurred_.id(); }

 private:
    GlProgram eye_, cut_eye_, visibility_, blur_;
    GlVertexArray nothing_;
    GlFramebuffer target_;
    GlTexture eye_normal_, eye_depth_, raw_, half_blurred_, blurred_;
};

}  // namespace tetfront
