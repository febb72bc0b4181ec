#pragma once
// What the lights see: a depth map for the key light, and the floor's darkness baked into a small texture.
//
//     Shadows shadows;
//     shadows.draw(buffers, studio, box, size, floor_height);
//     shadows.bind_key(program, 0, "light_from_eye", world_from_eye);
//     if (floor) shadows.draw_floor(clip_from_world, shade);

#include "server/render/frame_buffers.hpp"
#include "server/render/gl.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace tetfront {

/// Directions towards the lights, unit length, world space. They turn with the camera about the up axis, as if the
/// object stood on a turntable in front of it.
struct Studio {
    Eigen::Vector3f up, key, fill, rim;
    int up_axis;

    explicit Studio(const View& view);
};

class Shadows {
 public:
    Shadows();

    /// box: of everything that casts a shadow. size [m]: the object's length that scales softness, constant over a
    /// sequence. floor: height of the floor along the up axis, or none.
    void draw(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size,
              std::optional<float> floor);
    /// Sets light_depth, light_width and the matrix that takes positions of the program's space to the light's map;
    /// world_from_space: what that space is.
    void bind_key(const GlProgram& program, int unit, const char* matrix,
                  const Eigen::Matrix4f& world_from_space) const;
    /// Into the bound framebuffer, with the blending that is set. shade: encoded colour of full darkness.
    void draw_floor(const Eigen::Matrix4f& clip_from_world, const Eigen::Vector3f& shade) const;

 private:
    void draw_key(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size);
    void bake_floor(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size,
                    float floor);

    GlProgram depth_, sky_, bake_, blur_, floor_;
    GlVertexArray nothing_;  // core profile wants one even when no attribute is read
    GlFramebuffer target_;
    GlTexture key_depth_, height_, sky_map_, darkness_, scratch_, sky_scratch_;
    void blur(const GlTexture& image, const GlTexture& scratch) const;

    Eigen::Matrix4f light_from_world_;  // to texture space, 0..1
    Eigen::Matrix4f world_from_floor_;  // from 0..1
    float light_width_ = 1;             // [m] also the depth range
};

}  // namespace tetfront
