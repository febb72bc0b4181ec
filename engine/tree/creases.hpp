#pragma once
// Vertices on sharp edges, split so that each side has its own: whoever shades the surface with one normal per vertex
// then draws a cube's edges as edges, and a bunny's back still smooth.
//
//     surface = split_creases(std::move(surface), crease_angle);
//
// Copies share position and attachment, so they never come apart.

#include "engine/tree/surface.hpp"

namespace tetfront {

/// Edges at which the surface turns by more than this are sharp. [degrees]
inline constexpr double crease_angle = 55;

/// Triangles and their order stay, vertices keep their numbers, copies are appended. Triangles around a vertex that
/// hang together by edges that are not sharp share one copy. An edge of other than two triangles is sharp. The counts
/// of outside vertices are not changed.
Surface split_creases(Surface surface, double angle);

}  // namespace tetfront
