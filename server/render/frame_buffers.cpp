#include "server/render/frame_buffers.hpp"

#include "engine/base/error.hpp"
#include "server/render/cross_section.hpp"

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
    update_section(frame, view);
    update_arrows(frame, view, 0.006F * reference_length);
}

void FrameBuffers::update_lines(const Frame& frame, const View& view) {
    lines_.instances.clear();
    if (!view.wireframe && view.surface) return;
    const FrameTopology& topology = *frame.topology;
    ENSURE(topology.edge_level.size() == topology.edges.size(), topology.edge_level.size(), " levels of edges");
    lines_.instances.reserve(topology.edges.size());
    for (std::size_t e = 0; e < topology.edges.size(); ++e) {
        const auto [a, b] = topology.edges[e];
        ENSURE(a < frame.front_positions.size() && b < frame.front_positions.size(), "edge ", e, " is ", a, ' ', b);
        lines_.instances.push_back(
            {frame.front_positions[a], frame.front_positions[b], line_colour(topology.edge_level[e], view)});
    }
    lines_.upload();
}

void FrameBuffers::update_section(const Frame& frame, const View& view) {
    section_lines_.instances.clear();
    const CrossSection section = view.surface ? cross_section(frame, view) : CrossSection{};
    section_.set_triangles(section.triangles);
    if (section.triangles.empty()) return;
    section_.positions.upload(bytes(section.positions));
    section_.colours.upload(bytes(section.colours));
    section_.normals.upload(bytes(section.positions));  // not looked at
    if (!view.wireframe) return;
    for (const auto& [a, b] : section.edges) {
        std::array<std::uint8_t, 4> ink = section.colours[a];
        for (std::size_t c = 0; c < 3; ++c) ink[c] = static_cast<std::uint8_t>(ink[c] * (1 - ink_over_surface));
        ink[3] = 140;  // most edges are drawn from both sides
        section_lines_.instances.push_back({section.positions[a], section.positions[b], ink});
    }
    section_lines_.upload();
}

void FrameBuffers::update_arrows(const Frame& frame, const View& view, float radius) {
    Solid solid;
    std::vector<std::array<std::uint8_t, 4>> colours;
    const auto add = [&](const Point& from, const Point& to, Rgb c) {
        append_arrow(solid, from, to, radius);
        colours.resize(solid.positions.size(), {c.r, c.g, c.b, 255});
    };
    if (view.arrows) {
        for (const FramePull& pull : frame.pulls) add(pull.from, pull.to, pull_colour);
        for (const FrameForce& force : frame.forces) add(force.at, force_tip(*frame.model, force), force_colour);
    }
    arrows_.set_triangles(solid.triangles);
    if (solid.triangles.empty()) return;
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
    if (!cut_.isZero()) glEnable(GL_CLIP_DISTANCE0);
    lines_.draw();
    glDisable(GL_CLIP_DISTANCE0);
}

void FrameBuffers::Lines::upload() {
    buffer.upload(bytes(instances));
    constexpr int stride = sizeof(LineInstance);
    array.attribute(0, buffer, 3, GL_FLOAT, stride, offsetof(LineInstance, a), 1);
    array.attribute(1, buffer, 3, GL_FLOAT, stride, offsetof(LineInstance, b), 1);
    array.attribute(2, buffer, 4, GL_UNSIGNED_BYTE, stride, offsetof(LineInstance, colour), 1);
}

void FrameBuffers::Lines::draw() const {
    if (instances.empty()) return;
    array.bind();
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(instances.size()));
}

}  // namespace tetfront
