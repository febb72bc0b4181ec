#include "server/render/cross_section.hpp"

#include "engine/base/error.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/palette.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetfront {

namespace {

struct Corner {
    Point at;
    float value = 0;  // of the field
};

/// Where the plane meets the edge between two vertices, the same from both sides and from every tet around.
Corner crossing(const Frame& frame, const std::vector<float>& heights, std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const float t = heights[a] / (heights[a] - heights[b]);
    Corner corner;
    for (std::size_t i = 0; i < 3; ++i)
        corner.at[i] = frame.front_positions[a][i] + t * (frame.front_positions[b][i] - frame.front_positions[a][i]);
    if (!frame.front_values.empty()) corner.value = frame.front_values[a] + t * (frame.front_values[b] - frame.front_values[a]);
    return corner;
}

}  // namespace

CrossSection cross_section(const Frame& frame, const View& view) {
    CrossSection section;
    const FrameTopology& topology = *frame.topology;
    if (!view.cut || topology.pieces.empty()) return section;
    const std::size_t vertices = frame.front_positions.size();
    ENSURE(topology.piece_level.size() == topology.pieces.size() && topology.piece_young.size() == topology.pieces.size(),
           topology.pieces.size(), " pieces with ", topology.piece_level.size(), " levels");
    ENSURE(frame.front_values.empty() || frame.front_values.size() == vertices, frame.front_values.size(), " values");
    std::optional<ColourScale> scale;
    if (view.colouring != Colouring::level) scale = colour_scale(frame, view);

    const Vec3 normal = view.cut->normal.normalized();
    const double offset = normal.dot(view.cut->point);
    std::vector<float> heights(vertices);  // over the plane; none is 0, so that no crossing falls on a vertex
    for (std::size_t i = 0; i < vertices; ++i) {
        const Point& p = frame.front_positions[i];
        const double height = normal[0] * static_cast<double>(p[0]) + normal[1] * static_cast<double>(p[1]) + normal[2] * static_cast<double>(p[2]) - offset;
        heights[i] = height == 0 ? 1e-30F : static_cast<float>(height);
    }
    const auto to_bytes = [](Rgb c) { return std::array<std::uint8_t, 4>{c.r, c.g, c.b, 255}; };
    for (std::size_t piece = 0; piece < topology.pieces.size(); ++piece) {
        std::array<std::uint32_t, 4> above{}, below{};
        std::size_t up = 0, down = 0;
        bool finite = true;
        for (const std::uint32_t v : topology.pieces[piece]) {
            ENSURE(v < vertices, "piece ", piece, " has corner ", v, " of ", vertices);
            finite = finite && std::isfinite(heights[v]);
            if (heights[v] > 0) above[up++] = v;
            else below[down++] = v;
        }
        if (!finite || up == 0 || down == 0) continue;
        std::array<Corner, 4> polygon;
        std::size_t corners = 3;
        if (up == 2) {  // a quadrilateral: round it, neighbours share a vertex of the tet
            corners = 4;
            polygon = {crossing(frame, heights, above[0], below[0]), crossing(frame, heights, above[0], below[1]),
                       crossing(frame, heights, above[1], below[1]), crossing(frame, heights, above[1], below[0])};
        } else {
            const std::uint32_t tip = up == 1 ? above[0] : below[0];
            const auto& base = up == 1 ? below : above;
            for (std::size_t i = 0; i < 3; ++i) polygon[i] = crossing(frame, heights, tip, base[i]);
        }
        const auto first = static_cast<std::uint32_t>(section.positions.size());
        for (std::size_t i = 0; i < corners; ++i) {
            section.positions.push_back(polygon[i].at);
            section.colours.push_back(
                to_bytes(!scale ? level_colour(topology.piece_level[piece])
                                : scale->colour(static_cast<double>(view.colouring == Colouring::stiffness ? topology.piece_young[piece]
                                                                                                           : polygon[i].value))));
            section.edges.push_back({first + static_cast<std::uint32_t>(i), first + static_cast<std::uint32_t>((i + 1) % corners)});
        }
        for (std::uint32_t i = 2; i < corners; ++i) section.triangles.push_back({first, first + i - 1, first + i});
    }
    return section;
}

}  // namespace tetfront
