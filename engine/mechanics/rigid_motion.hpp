#pragma once
// Gives a free body back the momenta that a change of its front took: a merge takes the nodes' velocities as they are.
//
//     const Momentum before = elements.momentum(x, v);
//     ...                                                          // the front changes, `elements` is built anew
//     restore_momentum(before, front.vertices(), elements, size, x, v, scratch);

#include "engine/mechanics/elements.hpp"

namespace tetfront {

/// Adds to v the rigid motion after which linear and angular momentum are those of `before`. vertices: those of the front.
/// size: [m] of the object, for a well-conditioned system. scratch: room for one vector per vertex of the tree.
void restore_momentum(const Momentum& before, const std::vector<VertexId>& vertices, const ElementSet& elements,
                      double size, const PerVertex<Vec3>& x, PerVertex<Vec3>& v, PerVertex<Vec3>& scratch);

}  // namespace tetfront
