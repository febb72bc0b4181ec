#pragma once
// Repairs of the connectivity of tet meshes, wherever they come from.
//
//     separate_pinches(mesh);             // pieces that touch in a vertex or an edge only come apart
//     auto piece = connected_pieces(mesh);
//     mesh = keep_tets(mesh, [&](TetId t) { return piece[t] == 0; });
//     order_for_refinement(mesh);

#include "engine/mesh/tet_mesh.hpp"

#include <functional>

namespace tetfront {

/// Duplicates every vertex whose tets do not all hang together by faces that have this vertex, once for each further
/// group: a hinge in a point or an edge carries no moment and makes the stiffness matrix singular. Returns the number
/// of vertices added. Tets, their order and their shape stay.
std::size_t separate_pinches(TetMesh& mesh);

/// Edges around which the tets still form more than one fan, although each end's tets hang together.
std::size_t count_pinched_edges(const TetMesh& mesh);

/// Number of the piece that each tet is in; pieces hang together by faces and are numbered by their first tet.
PerTet<std::int32_t> connected_pieces(const TetMesh& mesh);

/// The tets for which keep() is true, in the same order; vertices compacted.
TetMesh keep_tets(const TetMesh& mesh, const std::function<bool(TetId)>& keep);

/// Reorders each tet's corners (volume stays positive) so that refinement, which cuts the inner octahedron between the
/// midpoints of edges 0-2 and 1-3, gives descendants with the best worst dihedral angle.
void order_for_refinement(TetMesh& mesh);

}  // namespace tetfront
