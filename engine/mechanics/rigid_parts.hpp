#pragma once
// The coarsest level of a preconditioner: rigid motions of parts of the root mesh. Levels of the tree end at its roots, and a
// root mesh of a real shape has long limbs of many tets; CG would carry a force along them one tet an iteration.
//
//     z = P A^-1 P^T r,     A = P^T (s_K K + s_M M + s_D D) P,     K, M, D of the linear root tets at rest
//
// P: up to `most` parts grow around vertices far from each other along edges; they overlap, and their weights w_a sum to one
// at each vertex (a partition of unity), which carries the rigid motions t_a + omega_a x (X - c) smoothly from part to part
// (Sarkis 2002; Smith, Bjorstad, Gropp 1996, section 2). A is small and dense, made for a material and inverted for a set of scales;
// both last until these change. What has turned since rest is turned back at each vertex by the rotation of the roots around it,
// so bending needs no new matrix.
//
//     RigidParts parts;
//     parts.build(tree, materials, pinned);              // after materials or pins changed
//     parts.update(h * h, 1, h, x);                      // before the products of a solve
//     parts.apply(r, z);                                 // [root vertices]

#include <vector>

#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/elements.hpp"

namespace tetfront {

class RigidParts {
 public:
    static constexpr std::size_t most = 48;            // parts
    static constexpr std::size_t vertices_of_one = 8;  // root vertices per part, about

    /// pinned: [V of the tree] nonzero: does not move. Cost: of the root mesh.
    void build(const TetTree& tree, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned);
    /// The next build makes everything anew; otherwise it does so only where pins have changed.
    void forget_materials() { parts_ = 0; built_ = false; }
    /// Too few roots for any: apply() must not be called.
    [[nodiscard]] bool empty() const { return parts_ == 0; }
    /// x: [V of the tree] positions, of the root vertices. All scales >= 0, not all zero.
    void update(double stiffness_scale, double mass_scale, double damping_scale, const PerVertex<Vec3>& x);
    /// r, z: [root vertices]; z is overwritten.
    void apply(const DofVector& r, DofVector& z) const;

 private:
    struct Weight {
        std::uint32_t part;
        double value;
    };
    struct Root {
        std::array<VertexId, 4> corner;
        Gradients<double> gradient;
        double volume;
    };
    void grow(const TetTree& tree);
    void assemble(const TetTree& tree, const TetMaterials& materials);
    /// Displacement of root vertex v at rest for the motion of a part: [1, -[(X - c) / size]x].
    [[nodiscard]] Eigen::Matrix<double, 3, 6> motion(VertexId v) const;

    bool built_ = false;
    std::size_t parts_ = 0;
    PerVertex<std::uint8_t> pinned_;                // [root vertices]
    PerVertex<Vec3> arm_;                           // [root vertices] (X - c) / size
    std::vector<Root> roots_;
    std::vector<std::uint32_t> weights_begin_;      // [root vertices + 1]
    std::vector<Weight> weights_;                   // none where pinned
    Eigen::MatrixXd stiffness_, mass_, damping_;    // [6 parts][6 parts]
    std::array<double, 3> scales_{};                // that inverse_ was made with
    Eigen::MatrixXd inverse_;  // floats would not do: single vertices make motions depend on each other
    PerVertex<Mat3> rotation_;                      // [root vertices]
    PerVertex<Mat3> turned_;                        // work space: sums of deformation gradients
    mutable Eigen::VectorXd load_, move_;           // [6 parts] work space
};

}  // namespace tetfront
