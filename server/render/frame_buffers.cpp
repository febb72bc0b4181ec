#include "server/render/frame_buffers.hpp"

#include "engine/base/error.hpp"

#include <cstddef>

namespace tetfront {

namespace {

/// Edges over the surface, which has the same colours, are this much darker.
constexpr double ink_over_surface = 0.5;

template <class T>
std::span<const std::byte> bytes(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

std::array<std::uint8_t, 4> line_colour(int level, const View& view) {
    const Rgb c = level_colour(level);
    const double keep = view.surface ? 1 - ink_over_surface : 1;
    const auto scale = [keep](std::uint8_t x) { return static_cast<std::uint8_t>(x * keep); };
    return {scale(c.r), scale(c.g), scale(c.b), static_cast<std::uint8_t>(view.surface ? 205 : 225)};
}

}  // namespace

FrameBuffers::Mesh::Mesh() {
    array.attribute(0, positions, 3);
    array.attribute(1, normals, 3);
    array.attribute(2, colours, 4, GL_UNSIGNED_BYTE);
}

void FrameBuffers::Mesh::set_triangles(std::span<const std::array<std::uint32_t, 3>> triangles_) {
    array.bind();
    triangles.upload(std::as_bytes(triangles_), GL_ELEMENT_ARRAY_BUFFER);
    index_count = static_cast<GLsizei>(3 * triangles_.size());
}

void FrameBuffers::Mesh::draw() const {
    if (index_count == 0) return;
    array.bind();
    glDrawElements(GL_TRIANGLES, index_count, GL_UNSIGNED_INT, nullptr);
}

void FrameBuffers::update(const Frame& frame, const View& view, float reference_length) {
    ENSURE(frame.model && frame.topology, "a frame without model or topology");
    const bool new_model = frame.model != model_;
    if (new_model) {
        faces_ = VertexFaces(frame.model->triangles, frame.surface.size());
        surface_.set_triangles(frame.model->triangles);
        closed_ = is_closed(frame.model->triangles);
    }
    const bool same_scale = colouring_ == view.colouring && range_ == view.range;
    if (new_model || !same_scale || frame.topology != topology_ || field_of(view.colouring) != Field::none) {
        const auto colours = surface_colours(frame, view);
        ENSURE(colours.size() == frame.surface.size(), colours.size(), " colours, ", frame.surface.size(), " vertices");
        surface_.colours.upload(bytes(colours));
    }
    model_ = frame.model, topology_ = frame.topology, colouring_ = view.colouring, range_ = view.range;
    cut_.setZero();
    if (view.cut) {
        const Vec3 normal = view.cut->normal.normalized();
        cut_ << normal.cast<float>(), static_cast<float>(normal.dot(view.cut->point));
    }
    show_surface_ = view.surface;
    faces_.normals(frame.surface, normals_);
    surface_.positions.upload(bytes(frame.surface));
    surface_.normals.upload(bytes(normals_));
    update_lines(frame, view);
    update_arrows(frame, view, 0.006F * reference_length);
}

void FrameBuffers::update_lines(const Frame& frame, const View& view) {
    lines_.clear();
    if (!view.wireframe && view.surface) return;
    const FrameTopology& topology = *frame.topology;
    ENSURE(topology.edge_level.size() == topology.edges.size(), topology.edge_level.size(), " levels of edges");
    lines_.reserve(topology.edges.size());
    for (std::size_t e = 0; e < topology.edges.size(); ++e) {
        const auto [a, b] = topology.edges[e];
        ENSURE(a < frame.front_positions.size() && b < frame.front_positions.size(), "edge ", e, " is ", a, ' ', b);
        lines_.push_back(
            {frame.front_positions[a], frame.front_positions[b], line_colour(topology.edge_level[e], view)});
    }
    line_buffer_.upload(bytes(lines_));
    constexpr int stride = sizeof(LineInstance);
    line_array_.attribute(0, line_buffer_, 3, GL_FLOAT, stride, offsetof(LineInstance, a), 1);
    line_array_.attribute(1, line_buffer_, 3, GL_FLOAT, stride, offsetof(LineInstance, b), 1);
    line_array_.attribute(2, line_buffer_, 4, GL_UNSIGNED_BYTE, stride, offsetof(LineInstance, colour), 1);
}

void FrameBuffers::update_arrows(const Frame& frame, const View& view, float radius) {
    Solid solid;
    if (view.arrows) {
        for (const FramePull& pull : frame.pulls) append_arrow(solid, pull.from, pull.to, radius);
    }
    arrows_.set_triangles(solid.triangles);
    if (solid.triangles.empty()) return;
    const std::vector<std::array<std::uint8_t, 4>> colours(solid.positions.size(),
                                                           {pull_colour.r, pull_colour.g, pull_colour.b, 255});
    arrows_.positions.upload(bytes(solid.positions));
    arrows_.normals.upload(bytes(solid.normals));
    arrows_.colours.upload(bytes(colours));
}

void FrameBuffers::draw_surface() const {
    if (!show_surface_) return;
    if (!cut_.isZero()) glEnable(GL_CLIP_DISTANCE0);
    surface_.draw();
    glDisable(GL_CLIP_DISTANCE0);
}
void FrameBuffers::draw_casters(bool mirrored) const {
    const bool one_side = closed_ && cut_.isZero();
    if (one_side) glEnable(GL_CULL_FACE), glCullFace(mirrored ? GL_FRONT : GL_BACK);
    draw_surface();
    if (one_side) glDisable(GL_CULL_FACE), glCullFace(GL_BACK);
}
void FrameBuffers::draw_arrows() const { arrows_.draw(); }

void FrameBuffers::draw_lines() const {
    if (lines_.empty()) return;
    line_array_.bind();
    if (!cut_.isZero()) glEnable(GL_CLIP_DISTANCE0);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines_.size()));
    glDisable(GL_CLIP_DISTANCE0);
}

}  // namespace tetfront
