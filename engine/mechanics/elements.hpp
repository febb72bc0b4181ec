#pragma once
// The active tets as batches of packs: evaluates forces, energies, strains and tangent blocks of a whole front.
//
// Built anew when the front changes; one call of evaluate() then visits every active tet once, several at a time, and
// leaves its results in element order. accumulate() adds them up per vertex by a list made at build time, in a fixed
// order, so results do not depend on the number of threads.
//
//     ElementSet elements;
//     elements.build(front, {matrices.elasticity, density});
//     elements.evaluate({.x = x, .force_scale = 1});
//     elements.accumulate(f);                               // f_v = internal force on each vertex of the front [N]
//     elements.energy();                                    // [J]

#include <cstdint>
#include <vector>

#include "engine/base/pooled.hpp"
#include "engine/base/simd.hpp"
#include "engine/base/strain_measure.hpp"
#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/mechanics/momentum.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

inline const PerTet<double> no_damping;

/// What every tet of the tree is made of. Refers to its parts.
struct TetMaterials {
    const PooledPerTet<Sym6>& elasticity;  // [Pa]
    const PerTet<double>& density;         // [kg/m^3]
    // Rayleigh damping: the force - (mass_damping M + stiffness_damping K) v of each tet. Empty: none.
    const PerTet<double>& mass_damping = no_damping;       // [1/s]
    const PerTet<double>& stiffness_damping = no_damping;  // [s]

    [[nodiscard]] bool damped() const { return !mass_damping.empty() || !stiffness_damping.empty(); }
};

class ElementSet {
 public:
    void build(const Front& front, const TetMaterials& materials);
    /// For the evaluations to come; also kept over build().
    void set_strain_measure(StrainMeasure measure) { strain_measure_ = measure; }
    [[nodiscard]] StrainMeasure strain_measure() const { return strain_measure_; }

    struct Evaluation {
        const PerVertex<Vec3>& x;                     // [m] positions, all vertices of the front
        double force_scale = 1;                       // nodal results: force_scale * f - M inertia, f internal and damping
        const PerVertex<Vec3>* inertia = nullptr;     // multiplied by the consistent mass; null: no such term
        const PerVertex<Vec3>* velocity = nullptr;    // [m/s] for damping; null: none
        bool tangent = false;                         // also the blocks stiffness_scale K + mass_scale M + damping_scale D
        double stiffness_scale = 0, mass_scale = 0, damping_scale = 0;
        /// Strain and stress in single precision: faster, and forces are off by some 1e-7 of the stiffness, which is little once
        /// strains are above 1e-3. Nodal results and energy alone, without tangent and inertia; potential(), inverted() and
        /// strain() stay those of the last double evaluation.
        bool single = false;
    };
    void evaluate(const Evaluation& e);

    /// f_v = sum of nodal results, for each vertex of the front (hanging ones too; restrict them afterwards).
    void accumulate(PerVertex<Vec3>& f) const;
    /// Elastic energy of the last evaluation [J].
    [[nodiscard]] double energy() const;
    /// What the nodal results of the last evaluation are minus the derivative of [J], with u the inertia, h the force
    /// scale, D the damping with rotations and velocities as they are: per unit of force,
    ///     elastic energy + (h/2) v^T D v + u^T M u / 2         (the incremental potential of an implicit step).
    [[nodiscard]] double potential() const;
    /// Active tets whose determinant of F is not positive at some quadrature point in the last evaluation.
    [[nodiscard]] int inverted() const;

    [[nodiscard]] std::size_t size() const { return tets_.size(); }
    [[nodiscard]] const std::vector<TetId>& tets() const { return tets_; }  // ascending
    [[nodiscard]] int order() const { return order_; }
    [[nodiscard]] int nodes() const { return order_ == 1 ? 4 : 10; }
    [[nodiscard]] int points() const { return order_ == 1 ? 1 : 4; }
    [[nodiscard]] int block_count() const { return nodes() * (nodes() + 1) / 2; }
    /// Strain (see strain_measure) of element e (index into tets()) at a quadrature point, from the last evaluation.
    [[nodiscard]] Vec6 strain(std::size_t e, int point) const;
    /// Volume-weighted sum of mass: the mass of the front [kg].
    [[nodiscard]] double mass() const;
    [[nodiscard]] Momentum momentum(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) const;
    /// sum_ij m_ij x_j [kg m]: the mass times its centre.
    [[nodiscard]] Vec3 first_moment(const PerVertex<Vec3>& x) const;
    /// (1/2) v^T M v [J]
    [[nodiscard]] double kinetic_energy(const PerVertex<Vec3>& v) const;

    /// Upper block (i <= j) of element e in the tangent of the last evaluation: 9 floats, column-major.
    [[nodiscard]] std::size_t block_offset(std::size_t e, int i, int j) const {
        const std::size_t block = static_cast<std::size_t>(i * nodes() - i * (i - 1) / 2 + (j - i));
        return (e * static_cast<std::size_t>(block_count()) + block) * 9;
    }
    [[nodiscard]] const float* blocks() const { return blocks_.data(); }

 private:
    /// What stays constant while the front does; lanes beyond the last tet repeat it with no volume.
    struct Batch {
        std::int32_t node[10][pack_size];
        double gradient[9][pack_size];   // rows G_1 G_2 G_3
        double volume[pack_size];        // [m^3]
        std::uint32_t stiffness;         // into stiffness_
        double mass[pack_size];          // [kg]
        double mass_damping[pack_size];       // [1/s]
        double stiffness_damping[pack_size];  // [s]
    };
    struct BatchStiffness {
        double c[21][pack_size];  // [Pa]
    };
    void pool_stiffness(const PooledPerTet<Sym6>& elasticity);
    /// The same of two batches in single precision.
    struct SinglePair {
        float gradient[9][2 * pack_size];
        float volume[2 * pack_size];
        float stiffness_damping[2 * pack_size];
        std::uint32_t stiffness;  // into single_stiffness_
    };
    struct SingleStiffness {
        float c[21][2 * pack_size];
    };
    void prepare_single();
    template <int Order, template <class> class Strain>
    void evaluate_pair(std::size_t pair, const Evaluation& e);
    void evaluate_single(const Evaluation& e);
    template <int Order>
    Pack add_inertia(const Batch& batch, const Evaluation& e, const std::array<V3<Pack>, ElementOrder<Order>::nodes>& xdot,
                     std::array<V3<Pack>, ElementOrder<Order>::nodes>& nodal) const;
    template <int Order, template <class> class Strain>
    void evaluate_batch(std::size_t b, const Evaluation& e);
    template <int Order>
    [[nodiscard]] double kinetic_energy_of(const PerVertex<Vec3>& v) const;

    int order_ = 1;
    bool damped_ = false;
    StrainMeasure strain_measure_ = StrainMeasure::corotated;
    std::vector<TetId> tets_;
    std::vector<Batch> batches_;
    std::vector<BatchStiffness> stiffness_;
    std::vector<SinglePair> single_;  // empty until single precision is asked for
    std::vector<SingleStiffness> single_stiffness_;
    std::vector<double> nodal_;     // [batch][node][lane][nodal_stride]
    std::vector<double> strains_;   // [batch][point][6][lane]
    std::vector<double> energies_;  // [batch][lane] twice the energy
    std::vector<double> motions_;   // [batch][lane] twice what potential() adds to it
    std::vector<double> orientation_;  // [batch][lane] smallest over the points; negative: inverted
    std::vector<float> blocks_;     // [element][block][9]
    std::vector<VertexId> vertices_;               // of the front
    PerVertex<std::int32_t> slot_;                 // [V of the tree] index into vertices_; only theirs are valid
    std::vector<std::uint32_t> incidence_begin_;   // [vertices+1]
    std::vector<std::uint32_t> incidence_;         // offsets into nodal_
};

}  // namespace tetfront
