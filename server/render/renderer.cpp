#include "server/render/renderer.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "server/render/frame_buffers.hpp"
#include "server/render/gl_context.hpp"
#include "server/render/legend.hpp"
#include "server/render/shaders.hpp"
#include "server/render/shadows.hpp"
#include "server/render/visibility.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr int largest_tile = 2560;        // [samples] memory of a tile: 8 bytes a sample
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

/// Part of the picture, in samples, GL's bottom-up rows.
struct Tile {
    int x, y, width, height;
};

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
    GlProgram surface{"surface", version + shaders::common + shaders::cut_vertex + shaders::surface_vertex,
                      version + shaders::common + shaders::cut_fragment + shaders::surface_fragment};
    GlProgram lines{"lines", version + shaders::cut_vertex + shaders::line_vertex, version + shaders::line_fragment};
    GlVertexArray nothing;
    GlFramebuffer target;
    GlTexture colour, depth;
    FrameBuffers buffers;
    Shadows shadows;
    Visibility visibility;
    Legend legend;
    std::vector<std::uint8_t> samples;  // read back: RGBA, bottom-up

    void draw_tile(const Tile& tile, const View& view, const Projection& projection, const Studio& studio, float size);
    void draw_lines(const Tile& tile, const View& view, const Projection& projection, const Matrix4f& clip, float size);
    void resolve(const Tile& tile, const View& view, Image& image);
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
    const Eigen::AlignedBox3f box = bounds(frame, false, view.arrows);
    const Studio studio(view);
    const Projection projected = projection(view, bounds(frame, with_lines, view.arrows), view.floor);

    impl_->buffers.update(frame, view, size);
    std::optional<float> floor;
    if (view.floor) floor = static_cast<float>(*view.floor);
    if (impl_->buffers.has_solids()) {
        impl_->shadows.draw(impl_->buffers, studio, box, size, floor);
        impl_->visibility.draw(impl_->buffers, view, projected.clip_from_eye, studio, impl_->shadows, box, size);
    }

    Image image(view.width, view.height, view.background == Background::transparent ? 4 : 3);
    const int step = largest_tile / view.supersampling * view.supersampling;
    const int width = view.width * view.supersampling, height = view.height * view.supersampling;
    for (int y = 0; y < height; y += step) {
        for (int x = 0; x < width; x += step) {
            const Tile tile{x, y, std::min(step, width - x), std::min(step, height - y)};
            impl_->draw_tile(tile, view, projected, studio, size);
            impl_->resolve(tile, view, image);
        }
    }
    impl_->context.check_errors("Renderer::render");
    if (view.legend) impl_->legend.draw(image, frame, view, title);
    return image;
}

void Renderer::Impl::draw_tile(const Tile& tile, const View& view, const Projection& projected, const Studio& studio,
                               float size) {
    const auto width = static_cast<float>(view.width * view.supersampling);
    const auto height = static_cast<float>(view.height * view.supersampling);
    const auto tile_width = static_cast<float>(tile.width), tile_height = static_cast<float>(tile.height);
    const Vector4f in_picture(tile_width / width, tile_height / height, static_cast<float>(tile.x) / width,
                              static_cast<float>(tile.y) / height);
    // Zoom into the tile: its part of the picture's [-1, 1]^2 becomes [-1, 1]^2.
    Matrix4f zoom = Matrix4f::Identity();
    zoom(0, 0) = 1 / in_picture[0], zoom(1, 1) = 1 / in_picture[1];
    zoom(0, 3) = (1 - 2 * in_picture[2]) / in_picture[0] - 1;
    zoom(1, 3) = (1 - 2 * in_picture[3]) / in_picture[1] - 1;
    const Matrix4f clip = zoom * projected.clip_from_world;

    colour.allocate(tile.width, tile.height, GL_RGBA8, GL_NEAREST);
    depth.allocate(tile.width, tile.height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    target.bind(&colour, &depth);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDisable(GL_DEPTH_TEST);
    const Tone tones = tone(view.background);
    if (view.background != Background::transparent) {
        nothing.bind();
        background.use();
        background.set("top", tones.top);
        background.set("bottom", tones.bottom);
        background.set("tile", in_picture);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    if (view.floor && buffers.has_solids()) shadows.draw_floor(clip, tones.shade);

    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    if (buffers.has_solids()) {
        surface.use();
        surface.set_texture("visibility", 0, GL_TEXTURE_2D, visibility.texture());
        surface.set("clip_from_world", clip);
        surface.set("eye_position", Vector3f(view.eye.cast<float>()));
        surface.set("cut", buffers.cut());
        surface.set("up", studio.up);
        surface.set("key_light", studio.key);
        surface.set("fill_light", studio.fill);
        surface.set("rim_light", studio.rim);
        surface.set("tile", in_picture);
        surface.set("tile_samples", Eigen::Vector2f(tile_width, tile_height));
        buffers.draw_surface();
        buffers.draw_arrows();
    }
    draw_lines(tile, view, projected, clip, size);
}

void Renderer::Impl::draw_lines(const Tile& tile, const View& view, const Projection& projected, const Matrix4f& clip,
                                float size) {
    glEnable(GL_BLEND);
    glDepthMask(GL_FALSE);
    const double scale = std::max(1.0, std::sqrt(view.height / 720.0)) * view.supersampling;
    lines.use();
    lines.set("clip_from_world", clip);
    lines.set("tile_samples", Eigen::Vector2f(static_cast<float>(tile.width), static_cast<float>(tile.height)));
    lines.set("half_width", static_cast<float>(line_half_width * scale));
    lines.set("cut", buffers.cut());
    lines.set("eye", Vector3f(view.eye.cast<float>()));
    lines.set("bias", 0.004F * size);
    lines.set("near_plane", projected.near_plane);
    // Without a surface the far side shows through: fade it.
    const float far_side = projected.far_plane;
    lines.set("fade", view.surface ? Eigen::Vector2f(far_side * 2, far_side * 3)
                                   : Eigen::Vector2f(projected.near_plane, far_side));
    buffers.draw_lines();
    glDepthMask(GL_TRUE);
}

void Renderer::Impl::resolve(const Tile& tile, const View& view, Image& image) {
    const auto stride = static_cast<std::size_t>(tile.width) * 4;
    samples.resize(stride * static_cast<std::size_t>(tile.height));
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, tile.width, tile.height, GL_RGBA, GL_UNSIGNED_BYTE, samples.data());
    const int n = view.supersampling, columns = tile.width / n, rows = tile.height / n;
    const unsigned count = static_cast<unsigned>(n * n);
    parallel_for(static_cast<std::size_t>(rows), 32, [&](std::size_t begin, std::size_t end) {
        std::vector<unsigned> sums(static_cast<std::size_t>(columns) * 4);
        for (std::size_t row = begin; row < end; ++row) {
            std::ranges::fill(sums, 0U);
            for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
                const std::uint8_t* sample = samples.data() + (row * static_cast<std::size_t>(n) + k) * stride;
                for (std::size_t x = 0; x < static_cast<std::size_t>(columns); ++x) {
                    for (int i = 0; i < n; ++i, sample += 4) {
                        for (std::size_t c = 0; c < 4; ++c) sums[4 * x + c] += sample[c];
                    }
                }
            }
            std::uint8_t* out = image.pixel(tile.x / n, view.height - 1 - tile.y / n - static_cast<int>(row));
            for (std::size_t x = 0; x < static_cast<std::size_t>(columns); ++x, out += image.channels) {
                const unsigned* sum = &sums[4 * x];
                if (image.channels == 3) {
                    for (std::size_t c = 0; c < 3; ++c)
                        out[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
                } else {  // premultiplied -> straight
                    const unsigned alpha = sum[3];
                    for (std::size_t c = 0; c < 3; ++c)
                        out[c] =
                            static_cast<std::uint8_t>(alpha ? std::min(255U, (sum[c] * 255 + alpha / 2) / alpha) : 0);
                    out[3] = static_cast<std::uint8_t>((alpha + count / 2) / count);
                }
            }
        }
    });
}

}  // namespace tetfront
