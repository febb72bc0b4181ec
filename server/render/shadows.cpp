#include "server/render/shadows.hpp"

#include "server/render/shaders.hpp"
#include "server/render/shadow_shaders.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tetfront {

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr int key_map_size = 1024, floor_map_size = 256, height_map_size = 192, sky_map_size = 96;

std::string full(std::initializer_list<const char*> parts) {
    std::string source = shaders::version;
    for (const char* part : parts) source += part;
    return source;
}

/// [-1, 1]^3 -> [0, 1]^3
Matrix4f texture_from_clip() {
    Matrix4f m = Matrix4f::Identity() * 0.5F;
    m.col(3) << 0.5F, 0.5F, 0.5F, 1;
    return m;
}

/// Smallest of the steps 1.15^k * unit that is not below x: maps that change size in steps only do not swim.
float stepped(float x, float unit) {
    return unit * std::pow(1.15F, std::ceil(std::log(std::max(x, 1e-3F * unit) / unit) / std::log(1.15F)));
}

}  // namespace

Studio::Studio(const View& view) : up_axis(view.up) {
    up = Vector3f::Unit(view.up);
    Vector3f back = (view.eye - view.target).cast<float>();
    back -= back.dot(up) * up;
    if (back.norm() < 1e-6F) back = up.unitOrthogonal();
    back.normalize();
    const Vector3f right = up.cross(back);
    key = (1.15F * up - 0.75F * right + 0.55F * back).normalized();
    fill = (0.25F * up + 0.9F * right + 0.6F * back).normalized();
    rim = (0.5F * up + 0.6F * right - 0.8F * back).normalized();
}

Shadows::Shadows()
    : depth_("depth", full({shaders::cut_vertex, shaders::depth_vertex}), full({shaders::depth_fragment})),
      sky_("floor sky", full({shaders::full_screen_vertex}), full({shaders::sampling, shaders::floor_sky_fragment})),
      bake_("floor bake", full({shaders::full_screen_vertex}), full({shaders::sampling, shaders::floor_bake_fragment})),
      blur_("floor blur", full({shaders::full_screen_vertex}), full({shaders::floor_blur_fragment})),
      floor_("floor", full({shaders::floor_vertex}), full({shaders::floor_fragment})) {}

void Shadows::draw(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size,
                   std::optional<float> floor) {
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    draw_key(buffers, studio, box, size);
    if (floor) bake_floor(buffers, studio, box, size, *floor);
}

void Shadows::draw_key(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size) {
    const float radius = stepped(0.53F * box.diagonal().norm(), size);
    light_width_ = 2 * radius;
    const Vector3f x = studio.up.cross(studio.key).normalized(), y = studio.key.cross(x);
    const float texel = light_width_ / key_map_size;
    const auto snapped = [&](const Vector3f& axis) { return texel * std::round(axis.dot(box.center()) / texel); };
    Matrix4f clip_from_world = Matrix4f::Identity();
    clip_from_world.row(0) << x.transpose() / radius, -snapped(x) / radius;
    clip_from_world.row(1) << y.transpose() / radius, -snapped(y) / radius;
    clip_from_world.row(2) << -studio.key.transpose() / radius, studio.key.dot(box.center()) / radius;
    light_from_world_ = texture_from_clip() * clip_from_world;

    key_depth_.allocate(key_map_size, key_map_size, GL_DEPTH_COMPONENT32F, GL_LINEAR);
    target_.bind(nullptr, &key_depth_);
    glClear(GL_DEPTH_BUFFER_BIT);
    depth_.use();
    depth_.set("clip_from_world", clip_from_world);
    depth_.set("cut", buffers.cut());
    buffers.draw_casters(false);
    buffers.draw_arrows();
}

void Shadows::bake_floor(const FrameBuffers& buffers, const Studio& studio, const Eigen::AlignedBox3f& box, float size,
                         float floor) {
    // A square under the object that reaches to where the key light throws its shadow.
    const int up = studio.up_axis, u = (up + 1) % 3, v = (up + 2) % 3;
    const float above = std::max(0.0F, box.center()[up] - floor);
    const Vector3f shift = -studio.key / studio.key[up] * above;
    const float half = stepped(0.75F * size + 0.5F * box.diagonal().norm() + 0.5F * shift.norm(), size);
    const float width = 2 * half;
    const float texel = width / floor_map_size;
    world_from_floor_ = Matrix4f::Zero();
    world_from_floor_(u, 0) = world_from_floor_(v, 1) = width;
    world_from_floor_(up, 2) = 1;
    world_from_floor_(u, 3) = texel * std::round((box.center()[u] + 0.5F * shift[u]) / texel) - half;
    world_from_floor_(v, 3) = texel * std::round((box.center()[v] + 0.5F * shift[v]) / texel) - half;
    world_from_floor_(up, 3) = floor;
    world_from_floor_(3, 3) = 1;

    // The object's underside, seen from below; what is under the floor counts as touching it.
    const float height_range = std::max(box.max()[up] - floor, 0.1F * size);
    Matrix4f clip_from_floor = Matrix4f::Identity();
    clip_from_floor.diagonal() << 2, 2, 2 / height_range, 1;
    clip_from_floor.col(3) << -1, -1, -1, 1;
    height_.allocate(height_map_size, height_map_size, GL_DEPTH_COMPONENT32F, GL_LINEAR);
    target_.bind(nullptr, &height_);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_CLAMP);
    depth_.use();
    depth_.set("clip_from_world", Matrix4f(clip_from_floor * world_from_floor_.inverse()));
    depth_.set("cut", buffers.cut());
    buffers.draw_casters(true);
    glDisable(GL_DEPTH_CLAMP);

    glDisable(GL_DEPTH_TEST);
    nothing_.bind();
    sky_map_.allocate(sky_map_size, sky_map_size, GL_R8, GL_LINEAR);
    sky_scratch_.allocate(sky_map_size, sky_map_size, GL_R8, GL_LINEAR);
    target_.bind(&sky_map_, nullptr);
    sky_.use();
    sky_.set_texture("height", 0, GL_TEXTURE_2D, height_.id());
    sky_.set("height_range", height_range);
    sky_.set("floor_width", width);
    sky_.set("size", size);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    blur(sky_map_, sky_scratch_);

    darkness_.allocate(floor_map_size, floor_map_size, GL_R8, GL_LINEAR);
    scratch_.allocate(floor_map_size, floor_map_size, GL_R8, GL_LINEAR);
    target_.bind(&darkness_, nullptr);
    bake_.use();
    bake_.set_texture("light_depth", 0, GL_TEXTURE_2D, key_depth_.id());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_NONE);
    bake_.set_texture("hidden_sky", 1, GL_TEXTURE_2D, sky_map_.id());
    bake_.set("light_from_world", light_from_world_);
    bake_.set("world_from_floor", world_from_floor_);
    bake_.set("light_width", light_width_);
    bake_.set("size", size);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    blur(darkness_, scratch_);
}

void Shadows::blur(const GlTexture& image, const GlTexture& scratch) const {
    blur_.use();
    for (const bool along : {false, true}) {
        target_.bind(along ? &image : &scratch, nullptr);
        blur_.set_texture("source", 0, GL_TEXTURE_2D, along ? scratch.id() : image.id());
        blur_.set("direction", Eigen::Vector2f(along ? 1.0F / static_cast<float>(image.width()) : 0.0F,
                                               along ? 0.0F : 1.0F / static_cast<float>(image.height())));
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

void Shadows::bind_key(const GlProgram& program, int unit, const char* matrix, const Matrix4f& world_from_space) const {
    program.set_texture("light_depth", unit, GL_TEXTURE_2D, key_depth_.id());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    program.set(matrix, Matrix4f(light_from_world_ * world_from_space));
    program.set("light_width", light_width_);
}

void Shadows::draw_floor(const Matrix4f& clip_from_world, const Vector3f& shade) const {
    nothing_.bind();
    floor_.use();
    floor_.set_texture("darkness", 0, GL_TEXTURE_2D, darkness_.id());
    floor_.set("clip_from_world", clip_from_world);
    floor_.set("world_from_floor", world_from_floor_);
    floor_.set("shade", shade);
    glEnable(GL_CULL_FACE);  // seen from below it is not there
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glDisable(GL_CULL_FACE);
}

}  // namespace tetfront
