#pragma once
// A frame in GL buffers. What did not change since the last frame (triangles, colours) is not sent again.
//
//     FrameBuffers buffers;
//     buffers.update(frame, view);
//     buffers.draw_surface();           // with a program that reads attributes 0 position, 1 normal, 2 colour

#include "server/render/geometry.hpp"
#include "server/render/gl.hpp"

#include <array>
#include <memory>
#include <optional>

namespace tetfront {

class FrameBuffers {
 public:
    /// reference_length [m]: sets the thickness of arrows.
    void update(const Frame& frame, const View& view, float reference_length);

    /// Whether there is anything but lines.
    [[nodiscard]] bool has_solids() const { return show_surface_ || arrows_.index_count > 0; }
    /// For depth maps: of a closed surface without a cut only the side that faces the light, the nearer one anyway.
    /// mirrored: the map's x, y and depth are left-handed.
    void draw_casters(bool mirrored) const;
    void draw_surface() const;  // nothing when the view hides the surface; cut where the view says so
    /// The view's cut as (normal, normal . point) for the programs' `cut`; zeros: none.
    [[nodiscard]] const Eigen::Vector4f& cut() const { return cut_; }
    void draw_arrows() const;
    /// The front's section with the view's cut, attributes as the surface's; and the edges in it if the view has edges.
    void draw_section() const { section_.draw(); }
    void draw_section_lines() const { section_lines_.draw(); }
    /// Attributes 0 and 1: ends, 2: colour; one instance of a 4-vertex strip per edge.
    void draw_lines() const;

 private:
    void update_lines(const Frame& frame, const View& view);
    void update_section(const Frame& frame, const View& view);
    void update_arrows(const Frame& frame, const View& view, float radius);

    struct Mesh {
        GlVertexArray array;
        GlBuffer positions, normals, colours, triangles;
        GLsizei index_count = 0;

        Mesh();
        void set_triangles(std::span<const std::array<std::uint32_t, 3>> triangles_);
        void draw() const;
    };
    struct LineInstance {
        Point a, b;
        std::array<std::uint8_t, 4> colour;
    };

    struct Lines {
        GlVertexArray array;
        GlBuffer buffer;
        std::vector<LineInstance> instances;

        void upload();
        void draw() const;
    };

    Mesh surface_, arrows_, section_;
    Lines lines_, section_lines_;

    bool closed_ = false;
    VertexFaces faces_;
    std::vector<Point> normals_;
    std::shared_ptr<const FrameModel> model_;        // whose triangles are in the buffers
    std::shared_ptr<const FrameTopology> topology_;  // whose colours are in the buffers
    Colouring colouring_{};
    std::optional<std::array<double, 2>> range_;
    bool show_surface_ = true;
    Eigen::Vector4f cut_ = Eigen::Vector4f::Zero();
};

}  // namespace tetfront
