#pragma once
// Numbers at the surface's and the front's vertices that a picture can show as colours, computed only when somebody asks.
//
//     FieldValues stress = surface_field(Field::stress, {front, elements, adaptivity, matrices, surface, x, points, front_x});
//
// Strain and stress live at the quadrature points. Each is averaged onto the corners of its tet, weighted by volume, and
// interpolated linearly inside of the active tets, so that the surface shows no steps at tets' faces.

#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/adaptivity.hpp"
#include "engine/mechanics/elasticity.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/simulation/frame.hpp"
#include "engine/tree/front.hpp"
#include "engine/tree/surface.hpp"

namespace tetfront {

struct FieldSource {
    const Front& front;
    const ElementSet& elements;      // evaluated at the present positions
    const Adaptivity& adaptivity;    // measured there
    const ElasticityMatrices& matrices;
    const Surface& surface;
    const std::vector<std::array<float, 3>>& positions;  // [S] of the surface now
    const std::vector<Front::Point>& points;             // [S] of the surface in the front
    const std::vector<std::array<float, 3>>& front_positions;  // [N] of the front's vertices now
};

/// >= 0, in the field's unit (see Field).
struct FieldValues {
    std::vector<float> surface;  // [S]
    std::vector<float> front;    // [N] at the front's vertices; at midpoints of edges the mean of the ends
};

/// Empty for Field::none. Cost: the front and the surface.
FieldValues surface_field(Field field, const FieldSource& source);

}  // namespace tetfront
