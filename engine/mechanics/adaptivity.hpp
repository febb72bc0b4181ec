#pragma once
// Which tets to split and which to merge: an energy-norm error indicator and a band for its total.
//
// Indicator of a tet, from the recovered (nodally averaged) strain e* and its own strain e (Zienkiewicz & Zhu 1987):
//
//     eta^2 = integral (e* - e)^T C (e* - e) + w integral e^T (C_average - C_uniform_stress) e          [J]
//
// Strain jumps where stiffness does, and that is no error: tets whose stiffness differs by a factor of four or more are averaged
// apart. The second term is what a coarse tet does not know about its material; it is zero where the material is uniform. The
// estimate of the relative displacement error is  sum eta^2 / sum integral e^T C e.  For tets whose children are all
// active the same formula on the parent's own nodes says what merging would cost, so both numbers are comparable.
//
// The front is left alone while the estimate is inside the band [lower, 1] x tolerance. Above it the worst tets are split
// until the predicted estimate is back in the middle, below it the cheapest merges are made; merges that cost next to
// nothing are made at any time. A budget bounds the number of tets: then the worst splits trade with the cheapest merges. A tet rests for `dwell` steps after it was activated before it may be merged away.
// The valid strain range of [Imai] eq. (6) splits a tet whatever its indicator, and forbids the merge into it.
//
//     Adaptivity adaptivity(matrices, unresolved);
//     adaptivity.measure(front, elements, x, dt, kinetic, settings);   // after elements.evaluate at x
//     auto [splits, merges] = adaptivity.adapt(front, step, settings);
//     adaptivity.rest(front.commit().activated, step, settings);

#include <limits>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/elasticity.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

struct AdaptivitySettings {
    double tolerance = 0.02;        // of the estimate
    double bracket_weight = 0.1;
    double lower_band = 0.4;        // of the tolerance: nothing is merged for economy above this
    double most_change = 0.05;      // of the front per step, unless the estimate is far off
    int dwell = 8;                  // steps
    /// Budget: the front never grows beyond this many tets. At the limit a tet is split only when another place can be
    /// merged at less than half of what the split gains (two queues, as in ROAM: Duchaineau et al. 1997).
    std::size_t most_tets = std::numeric_limits<std::size_t>::max();
    /// [J] energy below which deformations are taken for nothing.
    double energy_floor = 0;
    double memory = 1;              // [s] the energy that errors are measured against decays with this time constant
};

class Adaptivity {
 public:
    /// unresolved: [T of the tree] nonzero where a tet may never be active because it misses something that its
    /// descendants resolve (a small pinned region). Both must outlive this.
    Adaptivity(const ElasticityMatrices& matrices, const PerTet<std::uint8_t>& unresolved);

    /// Indicators of the active tets and of the parents whose children are all active. x: positions of the front's
    /// vertices that `elements` was last evaluated at. seconds: simulated time since the last call. kinetic [J]: energy
    /// of motion that will turn into deformation.
    void measure(const Front& front, const ElementSet& elements, const PerVertex<Vec3>& x, double seconds, double kinetic,
                 const AdaptivitySettings& settings);
    /// Relative displacement error, estimated, of the last measure().
    [[nodiscard]] double estimate() const { return estimate_; }
    /// eta^2 of active tet e (index as in ElementSet::tets()) [J].
    [[nodiscard]] const std::vector<double>& indicators() const { return eta2_; }

    /// Splits and merges on `front` as the last measure() asks for; the caller commits. Returns {splits, merges}.
    std::array<int, 2> adapt(Front& front, std::uint64_t step, const AdaptivitySettings& settings);
    /// Tets that became active rest for `dwell` steps.
    void rest(const std::vector<TetId>& activated, std::uint64_t step, const AdaptivitySettings& settings);
    /// Forgets energies and rests (after a reset).
    void clear();

    /// What is remembered from earlier steps: with it, measure() over 0 seconds leaves everything as it was.
    struct Memory {
        struct Rest {
            TetId tet;
            std::uint64_t until;  // step
        };
        double reference_energy = 0;  // [J] >= 0
        std::vector<Rest> rests;      // ascending tets; those that rest at `step`
    };
    [[nodiscard]] Memory memory(std::uint64_t step) const;
    void set_memory(const Memory& memory);

 private:
    struct MergeCandidate {
        TetId parent;
        double cost = 0;  // eta^2 of the parent minus that of the children [J]
    };
    /// The candidates' merges in the order of their costs; each at most once.
    class MergeQueue;
    template <int Order>
    void measure_order(const Front& front, const ElementSet& elements, const PerVertex<Vec3>& x, double bracket_weight);
    template <int Order>
    void group(const Front& front, const ElementSet& elements);
    template <int Order>
    void recover(const Front& front, const ElementSet& elements);
    template <int Order, class Strains, class AtNode>
    [[nodiscard]] double indicator(const Front& front, TetId t, const Strains& own, const AtNode& recovered, double bracket_weight) const;
    [[nodiscard]] bool in_valid_range(TetId t, const Vec6& strain) const;

    /// Recovered strain at a vertex, one for each class of stiffness around it.
    struct Recovered {
        Vec6 strain;
        double weight;      // [m^3] of the tets that were averaged
        std::int16_t kind;  // their class of stiffness
        std::int32_t next;  // of the same vertex; -1: none
    };
    /// That of a class at a vertex of the front; -1: no tet of this class has been averaged there.
    [[nodiscard]] std::int32_t find(VertexId v, std::int16_t kind) const;
    /// The strain of this class, or of the class with the most volume.
    [[nodiscard]] const Vec6& recovered_at(VertexId v, std::int16_t kind) const;

    const ElasticityMatrices* matrices_;
    const PerTet<std::uint8_t>* unresolved_;
    double reference_energy_ = 0, estimate_ = 0, eta2_total_ = 0;
    std::vector<double> eta2_;                  // [active]
    std::vector<std::uint8_t> out_of_range_;    // [active]
    std::vector<MergeCandidate> candidates_;
    std::vector<std::size_t> worst_;            // kept to save allocations
    PerTet<std::int16_t> kind_;                 // [T of the tree] class of stiffness
    PerVertex<std::int32_t> first_;             // [V of the tree] into recovered_, valid for the front's vertices
    std::vector<Recovered> recovered_;
    std::vector<std::uint32_t> group_of_node_;  // [active][nodes] into recovered_
    const Front* grouped_front_ = nullptr;      // that these are of
    std::uint32_t grouped_epoch_ = 0;
    PerTet<std::uint64_t> rest_until_;          // [T of the tree] step before which the tet is not merged away
};

}  // namespace tetfront
