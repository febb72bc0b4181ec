#pragma once
// What the renderer computes of a frame before GL sees it: smooth normals, colours, bounds, arrows. No GL here.
//
//     VertexFaces faces(model.triangles, frame.surface.size());    // once per model
//     std::vector<Vector3f> n = faces.normals(frame.surface);      // per frame

#include "engine/simulation/frame.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/view.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetfront {

using Point = std::array<float, 3>;

/// The triangles around every vertex.
class VertexFaces {
 public:
    VertexFaces() = default;
    VertexFaces(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t vertex_count);

    /// [S] unit normals: cross products of the corners' edges over their squared lengths (Max 1999), which is exact on
    /// a sphere and blind to how a flat face is cut into triangles. (0, 0, 1) where everything is degenerate.
    void normals(std::span<const Point> positions, std::vector<Point>& out) const;

 private:
    struct Corner {
        std::uint32_t next, last;  // the triangle's other vertices, counter-clockwise
    };
    std::vector<std::uint32_t> begin_;  // [S+1]
    std::vector<Corner> corners_;       // [3F]
};

/// Whether each edge of each triangle is an edge of exactly one other, which goes along it the other way.
bool is_closed(std::span<const std::array<std::uint32_t, 3>> triangles);

/// [S] RGBA of the surface's vertices. Throws InputError when the frame lacks what the view's colouring shows.
std::vector<std::array<std::uint8_t, 4>> surface_colours(const Frame& frame, const View& view);

/// Where the arrow of a force ends, as in the browser: one as long as the object's radius strains a block of that size, as
/// soft as the softest part, by a tenth. At least a third of that long, since thin objects bend by far smaller forces, and at most
/// one and a half times as long.
Point force_tip(const FrameModel& model, const FrameForce& force);

/// Box around all finite points of the frame: surface, front and arrows if asked for. A unit box if there is none.
Eigen::AlignedBox3f bounds(const Frame& frame, bool with_front, bool with_arrows = true);

/// A closed triangle mesh with normals of its own.
struct Solid {
    std::vector<Point> positions, normals;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Appends a ball at `from` and an arrow from there to `to` whose thickness is `radius` [m]. Without length: the ball.
void append_arrow(Solid& solid, const Point& from, const Point& to, float radius);

}  // namespace tetfront
