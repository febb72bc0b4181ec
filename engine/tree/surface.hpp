#pragma once
// The embedded smooth surface ([Imai] section 6): each surface vertex is attached to a leaf tet by barycentric
// coordinates once, and follows whatever active tet contains that leaf.
//
//     Surface skin = embed(surface_mesh, tree);
//     skin.attachment[i].leaf, skin.attachment[i].barycentric    // of surface vertex i
//
// Vertices outside of every tet attach to the nearest leaf, with barycentric coordinates that may be negative.

#include "engine/mesh/tet_mesh.hpp"
#include "engine/tree/tet_tree.hpp"

namespace tetfront {

struct Attachment {
    TetId leaf;
    Vec4 barycentric;  // sums to 1; components below 0 only for a vertex outside of all tets
};

struct Surface {
    SurfaceMesh mesh;                     // rest surface
    std::vector<Attachment> attachment;   // [mesh.positions.size()]
    std::size_t outside_count = 0;        // vertices outside of every tet
    double outside_distance = 0;          // [m] largest distance of such a vertex to its tet
};

Surface embed(SurfaceMesh mesh, const TetTree& tree);

}  // namespace tetfront
