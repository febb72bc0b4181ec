#pragma once
// The front where a plane cuts it: a polygon for each straight tet of the front, with the tet's colour. No GL here.
//
//     CrossSection section = cross_section(frame, view);         // empty without a cut, or when the frame has no pieces
//
// Tets reach beyond the object's surface; the renderer shows of the section what lies inside of it.

#include "engine/simulation/frame.hpp"
#include "server/render/geometry.hpp"
#include "server/render/view.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tetfront {

struct CrossSection {
    std::vector<Point> positions;                          // [Q] corners of polygons
    std::vector<std::array<std::uint8_t, 4>> colours;      // [Q]
    std::vector<std::array<std::uint32_t, 3>> triangles;   // fans of the polygons
    std::vector<std::array<std::uint32_t, 2>> edges;       // of the polygons; those of two neighbours come twice
};

/// Level and stiffness: one colour for each tet, that of its active tet. Fields: interpolated between the front's
/// vertices. Throws InputError when the frame lacks what the view's colouring shows.
CrossSection cross_section(const Frame& frame, const View& view);

}  // namespace tetfront
