#pragma once
// A multilevel preconditioner from the tree's own levels (Bramble, Pasciak, Xu 1990), for fronts of both orders:
//
//     z = J^-1 r + sum_l P_l S_l^-1 P_l^T r + P_0 (rigid motions of parts of the root mesh) P_0^T r
//
// J: the matrix's 3x3 diagonal blocks. Level l holds the vertices of the front up to level l of the tree; P_l carries their
// linear hat functions up by repeated midpoints, x_v = (x_a + x_b) / 2 over split edges. S_l: the diagonal of each
// level's own stiffness and mass as one scalar per vertex, which no rotation changes, so it is worked out once per front; and
// of springs and contacts at single points, which are carried down to the levels at each update: without them a stiff contact
// made CG take ten times as many iterations. The last term is that of rigid_parts.hpp; it is left out while there are contacts,
// of which it knows nothing.
// One descending and one ascending pass over the front's vertices apply it: far cheaper than a product with the matrix.
//
//     Multilevel multilevel;
//     multilevel.build(front, materials, pinned, matrix);     // after the front changed
//     multilevel.update(matrix, {h * h, 1, h, x});            // after the matrix was filled
//     pcg.solve(matrix, multilevel, ...);

#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/pcg.hpp"
#include "engine/mechanics/rigid_parts.hpp"

namespace tetfront {

class Multilevel : public Preconditioner {
 public:
    void build(const Front& front, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned,
               const BlockMatrix& matrix);
    /// The next build has other materials.
    void forget_materials() { rigid_.forget_materials(); }
    struct Update {
        double stiffness_scale, mass_scale, damping_scale;  // that the matrix was made with
        const PerVertex<Vec3>& x;                           // [m] positions
        /// Diagonal of what was added at points, each moved to the nodes by its weights; for the vertices of the front.
        const PerVertex<Vec3>* points = nullptr;
        bool contacts = false;                              // among them
    };
    void update(const BlockMatrix& matrix, const Update& u);
    void apply(const DofVector& r, DofVector& z) const override;

 private:
    struct Diagonal {
        double stiffness = 0, mass = 0, damping = 0;  // [N/m], [kg], [kg/s]
    };
    void add_level_diagonals(const Front& front, const TetMaterials& materials);
    /// The transpose of what carries hat functions of level l - 1 up to level l, on fine_.
    void restrict_level(std::size_t l) const;

    BlockJacobi jacobi_;
    RigidParts rigid_;
    bool with_rigid_ = false;
    std::vector<std::size_t> level_end_;                     // [levels] one past the last slot of a level's vertices
    std::vector<std::array<std::int32_t, 2>> ends_;          // [vertices of the front] slots of the split edge; -1: root
    std::vector<std::int32_t> dof_;                          // [vertices of the front] -1: hanging or pinned
    std::vector<VertexId> vertices_;                         // of the front
    std::vector<std::uint8_t> fixed_;                        // [vertices of the front]
    std::vector<std::vector<Diagonal>> diagonal_;            // [levels - 1][level_end_[l]]
    std::vector<DofVector> inverse_;                         // the same, of the scaled sum in each direction; 0 where fixed
    PerVertex<std::int32_t> slot_;                           // [V of the tree] valid for the front's vertices
    mutable std::vector<DofVector> coarse_;                  // [levels - 1][level_end_[l]] work space
    mutable DofVector fine_;                                 // [vertices of the front] work space
    mutable DofVector root_;                                 // [root vertices] work space
};

}  // namespace tetfront
