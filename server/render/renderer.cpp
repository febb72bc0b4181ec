#include "server/render/renderer.hpp"

#include "engine/base/error.hpp"
#include "server/render/compose.hpp"
#include "server/render/frame_buffers.hpp"
#include "server/render/gl_context.hpp"
#include "server/render/legend.hpp"
#include "server/render/shaders.hpp"
#include "server/render/shadows.hpp"
#include "server/render/surface_shaders.hpp"
#include "server/render/visibility.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr int largest_tile = 2560;        // [samples] along a side; memory of a tile: 8 bytes a sample
constexpr double line_half_width = 0.62;  // [pixels] of a picture 720 high
const std::string version = shaders::version;

struct Tone {
    Vector3f top, bottom, shade;  // encoded: background gradient, deepest shadow on the floor
};
Tone tone(Background background) {
    const auto grey = [](float r, float g, float b) { return Vector3f(r, g, b); };
    if (background == Background::dark)
        return {grey(0.145F, 0.155F, 0.172F), grey(0.20F, 0.21F, 0.228F), grey(0.02F, 0.022F, 0.03F)};
    return {grey(0.975F, 0.978F, 0.982F), grey(0.868F, 0.874F, 0.884F), grey(0.16F, 0.175F, 0.21F)};
}

/// Scale and offset of a part in the picture, both 0..1.
Vector4f share_of(const PixelBox& part, const View& view) {
    const auto width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    return {static_cast<float>(part.width) / width, static_cast<float>(part.height) / height,
            static_cast<float>(part.x) / width, static_cast<float>(part.y) / height};
}

/// Takes the part of the picture's [-1, 1]^2 to [-1, 1]^2.
Matrix4f zoom_to(const PixelBox& part, const View& view) {
    const Vector4f share = share_of(part, view);
    Matrix4f zoom = Matrix4f::Identity();
    zoom(0, 0) = 1 / share[0], zoom(1, 1) = 1 / share[1];
    zoom(0, 3) = (1 - 2 * share[2]) / share[0] - 1;
    zoom(1, 3) = (1 - 2 * share[3]) / share[1] - 1;
    return zoom;
}

/// Nothing in the lower left of what is bound, and drawing goes there.
void clear_part(int width, int height) {
    glViewport(0, 0, width, height);
    glScissor(0, 0, width, height);
    glEnable(GL_SCISSOR_TEST);
    glClearColor(0, 0, 0, 0);
    glDepthMask(GL_TRUE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
}

/// The lower left of what has been drawn.
void read(int width, int height, std::vector<std::uint8_t>& rgba) {
    rgba.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
}

struct Projection {
    Matrix4f clip_from_eye, clip_from_world;
    float near_plane, far_plane;
};

Projection projection(const View& view, const Eigen::AlignedBox3f& box, const std::optional<double>& floor) {
    const Matrix4f eye = eye_from_world(view);
    float nearest = 1e30F, farthest = 0;
    for (int i = 0; i < 8; ++i) {
        const Vector3f corner = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
        const float distance = -(eye * corner.homogeneous())[2];
        nearest = std::min(nearest, distance), farthest = std::max(farthest, distance);
    }
    const float size = box.diagonal().norm();
    if (floor) farthest += 8 * size, nearest = std::min(nearest, 0.2F * farthest);
    farthest = std::max(farthest + 0.1F * size, 1e-3F * size);
    nearest = std::max(nearest - 0.1F * size, 1e-3F * farthest);
    const Matrix4f clip = clip_from_eye(view, nearest, farthest);
    return {clip, clip * eye, nearest, farthest};
}

}  // namespace

struct Renderer::Impl {
    GlContext context;
    GlProgram background{"background", version + shaders::full_screen_vertex, version + shaders::background_fragment};
    GlProgram surface{"surface", version + shaders::colours + shaders::cut_vertex + shaders::surface_vertex,
                      version + shaders::colours + shaders::surface_fragment};
    GlProgram cut_surface{"cut surface", version + shaders::colours + shaders::cut_vertex + shaders::surface_vertex,
                          version + shaders::define_cut + shaders::colours + shaders::cut_fragment + shaders::surface_fragment};
    GlProgram section{"section", version + shaders::section_vertex, version + shaders::section_fragment};
    GlProgram lines{"lines", version + shaders::cut_vertex + shaders::line_vertex, version + shaders::line_fragment};
    GlVertexArray nothing;
    GlFramebuffer target;
    GlTexture backdrop, section_colour, colour, depth;
    FrameBuffers buffers;
    Shadows shadows;
    Visibility visibility;
    Legend legend;
    std::vector<std::uint8_t> behind, samples;  // read back: RGBA, bottom-up

    void draw_backdrop(const PixelBox& tile, const View& view, const Projection& projection);
    void draw_object(const PixelBox& part, const View& view, const Projection& projection, const Studio& studio, float size);
    void draw_section(const PixelBox& part, const View& view, const Projection& projection, const Matrix4f& clip);
    void prepare_lines(const PixelBox& part, const View& view, const Projection& projection, const Matrix4f& clip, float bias);
    void draw_lines(const PixelBox& part, const View& view, const Projection& projection, const Matrix4f& clip, float size);
};

Renderer::Renderer() : impl_(std::make_unique<Impl>()) {}
Renderer::~Renderer() {
    impl_->context.make_current();  // the members free their GL objects
}

Image Renderer::render(const Frame& frame, const View& view, const std::string& title) {
    impl_->context.make_current();
    validate(view);
    const auto& rest = frame.model->rest_box;
    const float size =
        std::max(1e-9F, (Eigen::Map<const Vector3f>(rest.data() + 3) - Eigen::Map<const Vector3f>(rest.data())).norm());
    const bool with_lines = view.wireframe || !view.surface;
    const Eigen::AlignedBox3f box = bounds(frame, false, view.arrows), whole = bounds(frame, with_lines, view.arrows);
    const Studio studio(view);
    const Projection projected = projection(view, whole, view.floor);

    impl_->buffers.update(frame, view, size);
    std::optional<float> floor;
    if (view.floor) floor = static_cast<float>(*view.floor);
    if (impl_->buffers.has_solids()) {
        impl_->shadows.draw(impl_->buffers, studio, box, size, floor);
        impl_->visibility.draw(impl_->buffers, view, projected.clip_from_eye, studio, impl_->shadows, box, size);
    }

    Image image(view.width, view.height, view.background == Background::transparent ? 4 : 3);
    const Vector3f room = Vector3f::Constant(0.02F * size);  // arrows are thicker than their axes
    const PixelBox object = covered({whole.min() - room, whole.max() + room}, projected.clip_from_world, view.width, view.height, 8);
    const int step = largest_tile / view.supersampling;
    for (int y = 0; y < view.height; y += step) {
        for (int x = 0; x < view.width; x += step) {
            const PixelBox tile{x, y, std::min(step, view.width - x), std::min(step, view.height - y)};
            const PixelBox part = common_part(tile, object);
            impl_->draw_backdrop(tile, view, projected);
            if (!part.empty()) impl_->draw_object(part, view, projected, studio, size);
            compose(tile, impl_->behind, {part, view.supersampling, impl_->samples}, image);
        }
    }
    impl_->context.check_errors("Renderer::render");
    if (view.legend) impl_->legend.draw(image, frame, view, title);
    return image;
}

/// Background and floor: smooth, so one sample a pixel is enough.
void Renderer::Impl::draw_backdrop(const PixelBox& tile, const View& view, const Projection& projected) {
    backdrop.allocate(tile.width, tile.height, GL_RGBA8, GL_NEAREST);
    target.bind(&backdrop, nullptr);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    const Tone tones = tone(view.background);
    if (view.background == Background::transparent) {
        glClearColor(0, 0, 0, 0);
        glClear(GL_COLOR_BUFFER_BIT);
    } else {
        nothing.bind();
        background.use();
        background.set("top", tones.top);
        background.set("bottom", tones.bottom);
        background.set("tile", share_of(tile, view));
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    if (view.floor && buffers.has_solids()) shadows.draw_floor(zoom_to(tile, view) * projected.clip_from_world, tones.shade);
    read(tile.width, tile.height, behind);
}

/// Surface, arrows and lines on nothing.
void Renderer::Impl::draw_object(const PixelBox& part, const View& view, const Projection& projected, const Studio& studio,
                                 float size) {
    const int width = part.width * view.supersampling, height = part.height * view.supersampling;
    const Matrix4f clip = zoom_to(part, view) * projected.clip_from_world;
    // Textures keep their size while the part follows the object.
    const int tile_width = std::min(largest_tile, view.width * view.supersampling);
    const int tile_height = std::min(largest_tile, view.height * view.supersampling);
    const bool cut = !buffers.cut().isZero();
    if (cut) {
        section_colour.allocate(tile_width, tile_height, GL_RGBA8, GL_NEAREST);
        draw_section(part, view, projected, clip);
    }
    colour.allocate(tile_width, tile_height, GL_RGBA8, GL_NEAREST);
    depth.allocate(tile_width, tile_height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    target.bind(&colour, &depth);
    clear_part(width, height);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    if (buffers.has_solids()) {
        const GlProgram& program = cut ? cut_surface : surface;
        program.use();
        program.set_texture("visibility", 0, GL_TEXTURE_2D, visibility.texture());
        if (cut) program.set_texture("section", 1, GL_TEXTURE_2D, section_colour.id());
        program.set("clip_from_world", clip);
        program.set("eye_position", Vector3f(view.eye.cast<float>()));
        program.set("cut", buffers.cut());
        program.set("up", studio.up);
        program.set("key_light", studio.key);
        program.set("fill_light", studio.fill);
        program.set("rim_light", studio.rim);
        program.set("tile", share_of(part, view));
        program.set("tile_samples", Eigen::Vector2f(static_cast<float>(width), static_cast<float>(height)));
        buffers.draw_surface();
        buffers.draw_arrows();
    }
    draw_lines(part, view, projected, clip, size);
    read(width, height, samples);
}

/// Colours of the tets inside, for where the surface's program finds the cut.
void Renderer::Impl::draw_section(const PixelBox& part, const View& view, const Projection& projected, const Matrix4f& clip) {
    target.bind(&section_colour, nullptr);
    clear_part(part.width * view.supersampling, part.height * view.supersampling);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    section.use();
    section.set("clip_from_world", clip);
    buffers.draw_section();
    prepare_lines(part, view, projected, clip, 0);
    buffers.draw_section_lines();
}

void Renderer::Impl::draw_lines(const PixelBox& part, const View& view, const Projection& projected, const Matrix4f& clip,
                                float size) {
    glDepthMask(GL_FALSE);
    prepare_lines(part, view, projected, clip, 0.004F * size);
    buffers.draw_lines();
    glDepthMask(GL_TRUE);
}

/// bias: [m] towards the eye.
void Renderer::Impl::prepare_lines(const PixelBox& part, const View& view, const Projection& projected, const Matrix4f& clip,
                                   float bias) {
    glEnable(GL_BLEND);
    const double scale = std::max(1.0, std::sqrt(view.height / 720.0)) * view.supersampling;
    lines.use();
    lines.set("clip_from_world", clip);
    lines.set("tile_samples", Eigen::Vector2f(static_cast<float>(part.width * view.supersampling),
                                               static_cast<float>(part.height * view.supersampling)));
    lines.set("half_width", static_cast<float>(line_half_width * scale));
    lines.set("cut", buffers.cut());
    lines.set("eye", Vector3f(view.eye.cast<float>()));
    lines.set("bias", bias);
    lines.set("near_plane", projected.near_plane);
    // Without a surface the far side shows through: fade it.
    const float far_side = projected.far_plane;
    lines.set("fade", view.surface ? Eigen::Vector2f(far_side * 2, far_side * 3)
                                   : Eigen::Vector2f(projected.near_plane, far_side));
}

}  // namespace tetfront
