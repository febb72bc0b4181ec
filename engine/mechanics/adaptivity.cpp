#include "engine/mechanics/adaptivity.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/parallel.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/mechanics/strain.hpp"

namespace tetfront {

namespace {

/// Strains at the quadrature points of one tet.
template <int Order>
using PointStrains = std::array<Vec6, ElementOrder<Order>::points>;

/// Strain at each node: the constant of a linear tet; for a quadratic one the linear function through its four
/// quadrature points, evaluated at corners and midpoints.
template <int Order>
std::array<Vec6, ElementOrder<Order>::nodes> strain_at_nodes(const PointStrains<Order>& at_points) {
    std::array<Vec6, ElementOrder<Order>::nodes> s;
    if constexpr (Order == 1) {
        s.fill(at_points[0]);
    } else {
        using O = ElementOrder<2>;
        const Vec6 sum = at_points[0] + at_points[1] + at_points[2] + at_points[3];
        for (std::size_t k = 0; k < 4; ++k) s[k] = (at_points[k] - O::far * sum) / (O::near - O::far);
        for (std::size_t e = 0; e < 6; ++e)
            s[4 + e] = (s[static_cast<std::size_t>(tet_edges[e][0])] + s[static_cast<std::size_t>(tet_edges[e][1])]) / 2;
    }
    return s;
}

template <int Order>
PointStrains<Order> strains_of(const ElementSet& elements, std::size_t e) {
    PointStrains<Order> s;
    for (int q = 0; q < ElementOrder<Order>::points; ++q) s[static_cast<std::size_t>(q)] = elements.strain(e, q);
    return s;
}

/// Strains that tet t would have with its nodes at x.
template <int Order>
PointStrains<Order> strains_at(const Front& front, TetId t, const PerVertex<Vec3>& x, StrainMeasure measure) {
    using O = ElementOrder<Order>;
    const TetTree& tree = front.tree();
    const auto& c = tree.corners(t);
    const auto g = barycentric_gradients({tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3])});
    const auto node = front.nodes(t);
    std::array<V3<double>, O::nodes> position;
    for (std::size_t i = 0; i < O::nodes; ++i) position[i] = {x[node[i]][0], x[node[i]][1], x[node[i]][2]};
    PointStrains<Order> s;
    for (int q = 0; q < O::points; ++q) {
        const M3<double> f = deformation_gradient<Order>(position, q, g);
        const V6<double> strain = measure == StrainMeasure::green ? GreenPoint<double>(f).strain() : CorotatedPoint<double>(f).strain();
        for (std::size_t m = 0; m < 6; ++m) s[static_cast<std::size_t>(q)][static_cast<int>(m)] = strain[m];
    }
    return s;
}

/// e^T C e, written out: as loops over Sym6::slot it was most of the time of a linear front's indicators. E: Vec6, or V6 of packs.
template <class E>
auto quadratic_form(const Sym6& c, const E& e) {
    using T = std::decay_t<decltype(e[0])>;
    const auto u = [&](std::size_t k) { return T(c.upper[k]); };
    const T two(2);
    return e[0] * (u(0) * e[0] + two * (u(1) * e[1] + u(2) * e[2] + u(3) * e[3] + u(4) * e[4] + u(5) * e[5])) +
           e[1] * (u(6) * e[1] + two * (u(7) * e[2] + u(8) * e[3] + u(9) * e[4] + u(10) * e[5])) +
           e[2] * (u(11) * e[2] + two * (u(12) * e[3] + u(13) * e[4] + u(14) * e[5])) +
           e[3] * (u(15) * e[3] + two * (u(16) * e[4] + u(17) * e[5])) + e[4] * (u(18) * e[4] + two * (u(19) * e[5])) + u(20) * e[5] * e[5];
}

template <int Order>
Vec6 mean(const PointStrains<Order>& s) {
    Vec6 sum = s[0];
    for (std::size_t q = 1; q < s.size(); ++q) sum += s[q];
    return sum / static_cast<double>(s.size());
}

}  // namespace

Adaptivity::Adaptivity(const ElasticityMatrices& matrices, const PerTet<std::uint8_t>& unresolved)
    : matrices_(&matrices), unresolved_(&unresolved), kind_(matrices.elasticity.size()) {
    for (TetId t : ids<TetId>(kind_.size())) {
        const Sym6& c = matrices.elasticity[t];
        double trace = 0;
        for (int i = 0; i < 6; ++i) trace += c(i, i);
        kind_[t] = static_cast<std::int16_t>(std::floor(std::log2(trace) / 2));
    }
}

std::int32_t Adaptivity::find(VertexId v, std::int16_t kind) const {
    std::int32_t n = first_[v];
    while (n >= 0 && recovered_[static_cast<std::size_t>(n)].kind != kind) n = recovered_[static_cast<std::size_t>(n)].next;
    return n;
}

const Vec6& Adaptivity::recovered_at(VertexId v, std::int16_t kind) const {
    std::int32_t best = find(v, kind);
    if (best < 0) {
        best = first_[v];
        for (std::int32_t n = best; n >= 0; n = recovered_[static_cast<std::size_t>(n)].next)
            if (recovered_[static_cast<std::size_t>(n)].weight > recovered_[static_cast<std::size_t>(best)].weight) best = n;
    }
    return recovered_[static_cast<std::size_t>(best)].strain;
}

bool Adaptivity::in_valid_range(TetId t, const Vec6& strain) const {
    if (matrices_->valid_range.empty()) return true;
    const auto& range = matrices_->valid_range[t];
    for (int m = 0; m < 6; ++m) {
        const auto& [low, high] = range[static_cast<std::size_t>(m)];
        if (!(low < strain[m] && strain[m] < high)) return false;
    }
    return true;
}

/// Which strains are averaged where: as long as the front is the same.
template <int Order>
void Adaptivity::group(const Front& front, const ElementSet& elements) {
    first_.resize(front.tree().vertex_count());
    recovered_.clear();
    for (VertexId v : front.vertices()) first_[v] = -1;
    constexpr std::size_t nodes = ElementOrder<Order>::nodes;
    group_of_node_.resize(elements.size() * nodes);
    for (std::size_t e = 0; e < elements.size(); ++e) {
        const TetId t = elements.tets()[e];
        const auto node = front.nodes(t);
        for (std::size_t i = 0; i < nodes; ++i) {
            std::int32_t n = find(node[i], kind_[t]);
            if (n < 0) {
                n = static_cast<std::int32_t>(recovered_.size());
                recovered_.push_back({Vec6::Zero(), 0, kind_[t], first_[node[i]]});
                first_[node[i]] = n;
            }
            recovered_[static_cast<std::size_t>(n)].weight += front.tree().volume(t);
            group_of_node_[e * nodes + i] = static_cast<std::uint32_t>(n);
        }
    }
}

template <int Order>
void Adaptivity::recover(const Front& front, const ElementSet& elements) {
    constexpr std::size_t nodes = ElementOrder<Order>::nodes;
    if (grouped_front_ != &front || grouped_epoch_ != front.epoch()) group<Order>(front, elements);
    grouped_front_ = &front, grouped_epoch_ = front.epoch();
    for (Recovered& r : recovered_) r.strain.setZero();
    for (std::size_t e = 0; e < elements.size(); ++e) {
        const double volume = front.tree().volume(elements.tets()[e]);
        const auto at_nodes = strain_at_nodes<Order>(strains_of<Order>(elements, e));
        for (std::size_t i = 0; i < nodes; ++i) recovered_[group_of_node_[e * nodes + i]].strain += volume * at_nodes[i];
    }
    for (Recovered& r : recovered_) r.strain /= r.weight;
    // The recovered field is conforming, like the displacement, where the tet that a vertex hangs on is of the same class.
    for (VertexId v : front.hanging()) {
        const TetTree::Row row = front.tree().row(Order, v);
        for (std::int32_t n = first_[v]; n >= 0; n = recovered_[static_cast<std::size_t>(n)].next) {
            Recovered& r = recovered_[static_cast<std::size_t>(n)];
            Vec6 strain = Vec6::Zero();
            bool whole = true;
            for (std::size_t k = 0; k < row.vertices.size() && whole; ++k) {
                const std::int32_t from = find(row.vertices[k], r.kind);
                whole = from >= 0;
                if (whole) strain += row.weights[k] * recovered_[static_cast<std::size_t>(from)].strain;
            }
            if (whole) r.strain = strain;
        }
    }
}

/// recovered(i): the recovered strain at node i.
template <int Order, class Strains, class AtNode>
double Adaptivity::indicator(const Front& front, TetId t, const Strains& own, const AtNode& recovered, double bracket_weight) const {
    using O = ElementOrder<Order>;
    const Sym6& c = matrices_->elasticity[t];
    const double volume = front.tree().volume(t);
    double sum = 0;
    if constexpr (Order == 1) {
        // The difference is linear in the tet: exact integral from its corner values.
        std::array<Vec6, 4> d;
        for (std::size_t i = 0; i < 4; ++i) d[i] = recovered(i) - own[0];
        if constexpr (pack_size == 4) {
            V6<Pack> lanes;
            for (int m = 0; m < 6; ++m) lanes[static_cast<std::size_t>(m)] = Pack([&](std::size_t i) { return d[i][m]; });
            sum = std::experimental::reduce(quadratic_form(c, lanes));
        } else {
            for (const Vec6& at : d) sum += quadratic_form(c, at);
        }
        sum = (sum + quadratic_form(c, Vec6(d[0] + d[1] + d[2] + d[3]))) / 20;
    } else {
        for (int q = 0; q < O::points; ++q) {
            Vec6 d = -own[static_cast<std::size_t>(q)];
            Vec4 b = Vec4::Constant(O::far);
            b[q] = O::near;
            const auto shape = quadratic_shape(b);
            for (std::size_t i = 0; i < 10; ++i) d += shape[i] * recovered(i);
            sum += quadratic_form(c, d) / O::points;
        }
    }
    if (bracket_weight > 0 && !matrices_->bracket.empty()) {
        for (const Vec6& e : own) sum += bracket_weight / O::points * quadratic_form(matrices_->bracket[t], e);
    }
    return volume * sum;
}

template <int Order>
void Adaptivity::measure_order(const Front& front, const ElementSet& elements, const PerVertex<Vec3>& x, double bracket_weight) {
    recover<Order>(front, elements);
    eta2_.resize(elements.size());
    out_of_range_.resize(elements.size());
    parallel_for(elements.size(), 128, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
            const TetId t = elements.tets()[e];
            const auto own = strains_of<Order>(elements, e);
            const std::uint32_t* group = &group_of_node_[e * ElementOrder<Order>::nodes];
            eta2_[e] = indicator<Order>(front, t, own, [&](std::size_t i) -> const Vec6& { return recovered_[group[i]].strain; }, bracket_weight);
            out_of_range_[e] = !in_valid_range(t, mean<Order>(own));
        }
    });
    eta2_total_ = std::accumulate(eta2_.begin(), eta2_.end(), 0.0);

    // Siblings are neighbours in the ascending list of active tets.
    const TetTree& tree = front.tree();
    candidates_.clear();
    for (std::size_t e = 0; e + 8 <= elements.size(); ++e) {
        const TetId t = elements.tets()[e];
        if (tree.is_root(t) || tree.child_number(t) != 0 || elements.tets()[e + 7].value != t.value + 7) continue;
        const TetId p = tree.parent(t);
        if ((*unresolved_)[p] || !front.can_merge(p)) continue;
        double children = 0;
        for (std::size_t k = 0; k < 8; ++k) children += eta2_[e + k];
        candidates_.push_back({p, -children});
        e += 7;
    }
    parallel_for(candidates_.size(), 32, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            MergeCandidate& candidate = candidates_[n];
            const auto own = strains_at<Order>(front, candidate.parent, x, elements.strain_measure());
            const auto node = front.nodes(candidate.parent);
            const auto recovered = [&](std::size_t i) -> const Vec6& { return recovered_at(node[i], kind_[candidate.parent]); };
            candidate.cost += indicator<Order>(front, candidate.parent, own, recovered, bracket_weight);
            if (!in_valid_range(candidate.parent, mean<Order>(own))) candidate.cost = std::numeric_limits<double>::infinity();
        }
    });
}

void Adaptivity::measure(const Front& front, const ElementSet& elements, const PerVertex<Vec3>& x, double seconds,
                         double kinetic, const AdaptivitySettings& settings) {
    if (front.order() == 1) {
        measure_order<1>(front, elements, x, settings.bracket_weight);
    } else {
        measure_order<2>(front, elements, x, settings.bracket_weight);
    }
    reference_energy_ = std::max({2 * (elements.energy() + kinetic), reference_energy_ * std::exp(-seconds / settings.memory), settings.energy_floor});
    estimate_ = reference_energy_ > 0 ? eta2_total_ / reference_energy_ : 0;
}

class Adaptivity::MergeQueue {
 public:
    MergeQueue(std::vector<MergeCandidate>& candidates, Front& front, const PerTet<std::uint64_t>& rest_until, std::uint64_t step)
        : candidates_(candidates), front_(front), rest_until_(rest_until), step_(step) {
        // Ties by number: as steady as a stable sort, which would allocate.
        std::sort(candidates_.begin(), candidates_.end(), [](const MergeCandidate& a, const MergeCandidate& b) {
            return a.cost != b.cost ? a.cost < b.cost : a.parent < b.parent;
        });
    }
    /// Cost of the cheapest merge that is possible now; infinite when there is none.
    double cheapest(bool also_resting = false) {
        for (; next_ < candidates_.size(); ++next_) {
            const TetId parent = candidates_[next_].parent;
            const bool resting = !also_resting && std::ranges::any_of(front_.tree().children(parent), [&](TetId t) { return rest_until_[t] > step_; });
            if (!resting && front_.can_merge(parent)) return candidates_[next_].cost;
        }
        return std::numeric_limits<double>::infinity();
    }
    /// Makes the merge that cheapest() found.
    void merge() { front_.merge(candidates_[next_++].parent); }
    void rewind() { next_ = 0; }

 private:
    std::vector<MergeCandidate>& candidates_;
    Front& front_;
    const PerTet<std::uint64_t>& rest_until_;
    std::uint64_t step_;
    std::size_t next_ = 0;
};

std::array<int, 2> Adaptivity::adapt(Front& front, std::uint64_t step, const AdaptivitySettings& settings) {
    rest_until_.resize(front.tree().tet_count(), 0);
    const std::vector<TetId>& tets = front.active();  // stays as it is until the caller commits
    const double goal = settings.tolerance * reference_energy_;
    const auto most = std::max<std::size_t>(4, static_cast<std::size_t>(settings.most_change * static_cast<double>(tets.size())));
    std::array<int, 2> changes = {0, 0};
    const auto fits = [&] { return front.active_count() + 7 <= settings.most_tets; };

    for (std::size_t e = 0; e < tets.size(); ++e) {
        const bool forced = (*unresolved_)[tets[e]] || (out_of_range_[e] && fits());
        if (forced && front.split(tets[e])) ++changes[0];
    }
    MergeQueue merges(candidates_, front, rest_until_, step);
    double total = eta2_total_;
    if (total > goal) {
        std::vector<std::size_t>& worst = worst_;
        worst.resize(tets.size());
        std::iota(worst.begin(), worst.end(), std::size_t{0});
        std::erase_if(worst, [&](std::size_t e) { return front.tree().level_of(tets[e]) >= front.max_level(); });
        std::sort(worst.begin(), worst.end(), [&](std::size_t a, std::size_t b) { return eta2_[a] != eta2_[b] ? eta2_[a] > eta2_[b] : a < b; });
        // What a split leaves of eta^2: h^2 for linear, at most h^4 (less near singularities) for quadratic tets.
        const double left = front.order() == 1 ? 0.25 : 0.125;
        const std::size_t limit = std::min(total > 4 * goal ? worst.size() : most, worst.size());
        for (std::size_t n = 0; n < limit && total > 0.7 * goal; ++n) {
            const double gain = (1 - left) * eta2_[worst[n]];
            if (!(gain > 0)) break;
            while (!fits() && merges.cheapest() < 0.5 * gain) {
                total += std::max(merges.cheapest(), 0.0);
                merges.merge();
                ++changes[1];
            }
            if (!fits()) break;
            if (front.split(tets[worst[n]])) ++changes[0];
            total -= gain;
        }
    } else {
        const bool economy = total < settings.lower_band * goal;
        const double next_to_nothing = 0.02 * goal / static_cast<double>(tets.size());
        while (static_cast<std::size_t>(changes[1]) < most) {
            const double cost = merges.cheapest();
            if (!(cost <= next_to_nothing || (economy && total + cost <= 0.6 * goal))) break;
            merges.merge();
            total += std::max(cost, 0.0);
            ++changes[1];
        }
    }
    merges.rewind();
    while (front.active_count() > settings.most_tets && std::isfinite(merges.cheapest(true))) {
        merges.merge();
        ++changes[1];
    }
    return changes;
}

void Adaptivity::rest(const std::vector<TetId>& activated, std::uint64_t step, const AdaptivitySettings& settings) {
    for (TetId t : activated) rest_until_[t] = step + static_cast<std::uint64_t>(settings.dwell);
}

void Adaptivity::clear() {
    reference_energy_ = estimate_ = eta2_total_ = 0;
    std::fill(rest_until_.begin(), rest_until_.end(), 0);
}

Adaptivity::Memory Adaptivity::memory(std::uint64_t step) const {
    Memory memory{reference_energy_, {}};
    for (TetId t : ids<TetId>(rest_until_.size()))
        if (rest_until_[t] > step) memory.rests.push_back({t, rest_until_[t]});
    return memory;
}

void Adaptivity::set_memory(const Memory& memory) {
    clear();
    reference_energy_ = memory.reference_energy;
    rest_until_.resize(kind_.size(), 0);
    for (const auto& [tet, until] : memory.rests) rest_until_[tet] = until;
}

}  // namespace tetfront
