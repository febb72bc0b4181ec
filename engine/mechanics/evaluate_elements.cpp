// Forces, energies, strains and tangents of all elements: ElementSet::evaluate.
#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/gather.hpp"
#include "engine/mechanics/nodal_forces.hpp"
#include "engine/mechanics/strain.hpp"

namespace tetfront {

namespace {

constexpr std::size_t batch_grain = 16;

/// The 4x4 blocks of an effective linear tet: rows and columns sum to zero.
struct EffectiveBlocks {
    M3<Pack> k[4][4];

    /// scale (frame a_kl frame^T + geometric_kl 1); geometric: [k-1][l-1], null for none.
    void set(const std::array<std::array<M3<Pack>, 3>, 3>& a, const M3<Pack>& frame, const M3<Pack>* geometric, const Pack& scale) {
        for (int r = 0; r < 3; ++r) {
            for (int c = r; c < 3; ++c) {
                M3<Pack>& block = k[r + 1][c + 1];
                block = mul_bt(mul(frame, a[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]), frame);
                if (geometric != nullptr)
                    for (std::size_t i = 0; i < 3; ++i) block.m[4 * i] += (*geometric)(r, c);
                for (Pack& v : block.m) v *= scale;
                if (r != c) transpose(block, k[c + 1][r + 1]);
            }
        }
        for (int r = 1; r < 4; ++r) {
            for (std::size_t m = 0; m < 9; ++m) k[r][0].m[m] = -(k[r][1].m[m] + k[r][2].m[m] + k[r][3].m[m]);
            transpose(k[r][0], k[0][r]);
        }
        for (std::size_t m = 0; m < 9; ++m) k[0][0].m[m] = -(k[1][0].m[m] + k[2][0].m[m] + k[3][0].m[m]);
    }

 private:
    static void transpose(const M3<Pack>& from, M3<Pack>& to) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) to(j, i) = from(i, j);
    }
};

/// Node blocks  sum_q sum_kl dN_i/dlambda_k dN_j/dlambda_l K^q_kl  of an element from the effective blocks K^q at its points.
template <int Order>
class NodeBlocks;

template <>
class NodeBlocks<1> {
 public:
    EffectiveBlocks& point(int) { return k_; }
    void prepare() {}
    [[nodiscard]] M3<Pack> block(int i, int j) const { return k_.k[i][j]; }

 private:
    EffectiveBlocks k_;
};

/// The weights are products of 4 lambda_a, and lambda_a = far + d [a = q], d = near - far. With Q^a = 8 far^2 S + 16 far d K^a and
/// S = sum_q K^q the sums over q become sums of two:
///
///     sum_q 16 lambda_a lambda_b K^q = Q^a + Q^b   (a = b: one d/far (Q^a - 8 far^2 S) more),      sum_q 4 lambda_a K^q = (Q^a + 8 far^2 S) / (4 far)
///
/// Term by term over the four points was twice the work.
template <>
class NodeBlocks<2> {
    using O = ElementOrder<2>;
    static constexpr double far = O::far, d = O::near - O::far, ratio = d / far;

 public:
    EffectiveBlocks& point(int q) { return q_[q]; }
    void prepare() {
        for (int k = 0; k < 4; ++k) {
            for (int l = 0; l < 4; ++l) {
                for (std::size_t m = 0; m < 9; ++m) {
                    const Pack half = Pack(8 * far * far) * (q_[0].k[k][l].m[m] + q_[1].k[k][l].m[m] + q_[2].k[k][l].m[m] + q_[3].k[k][l].m[m]);
                    for (EffectiveBlocks& q : q_) q.k[k][l].m[m] = half + Pack(16 * far * d) * q.k[k][l].m[m];
                    half_.k[k][l].m[m] = half;
                }
            }
        }
    }
    /// i <= j
    [[nodiscard]] M3<Pack> block(int i, int j) const {
        M3<Pack> sum = M3<Pack>::zero();
        if (j < 4) {
            add(i, j, i, j, sum);
            subtract(i, i, j, sum);
            subtract(j, i, j, sum);
            for (std::size_t m = 0; m < 9; ++m) sum.m[m] += Pack(1 / (8 * far * far)) * half_.k[i][j].m[m];
            return sum;
        }
        const int c = ends(j)[0], e = ends(j)[1];
        if (i < 4) {
            add(i, e, i, c, sum);
            add(i, c, i, e, sum);
            subtract(e, i, c, sum);
            subtract(c, i, e, sum);
            return sum;
        }
        const int a = ends(i)[0], b = ends(i)[1];
        add(b, e, a, c, sum);
        add(b, c, a, e, sum);
        add(a, e, b, c, sum);
        add(a, c, b, e, sum);
        return sum;
    }

 private:
    static const std::array<int, 2>& ends(int node) {
        static constexpr auto edges = [] {
            std::array<std::array<int, 2>, 6> all{};
            for (std::size_t e = 0; e < 6; ++e) all[e] = {static_cast<int>(tet_edges[e][0]), static_cast<int>(tet_edges[e][1])};
            return all;
        }();
        return edges[static_cast<std::size_t>(node - 4)];
    }
    /// sum += sum_q 16 lambda_a lambda_b K^q_kl
    void add(int a, int b, int k, int l, M3<Pack>& sum) const {
        const M3<Pack> &qa = q_[a].k[k][l], &qb = q_[b].k[k][l], &half = half_.k[k][l];
        if (a != b) {
            for (std::size_t m = 0; m < 9; ++m) sum.m[m] += qa.m[m] + qb.m[m];
        } else {
            for (std::size_t m = 0; m < 9; ++m) sum.m[m] += Pack(2 + ratio) * qa.m[m] - Pack(ratio) * half.m[m];
        }
    }
    /// sum -= sum_q 4 lambda_a K^q_kl
    void subtract(int a, int k, int l, M3<Pack>& sum) const {
        for (std::size_t m = 0; m < 9; ++m) sum.m[m] -= Pack(1 / (4 * far)) * (q_[a].k[k][l].m[m] + half_.k[k][l].m[m]);
    }

    EffectiveBlocks q_[4], half_;
};

/// [k-1][l-1]: G_k . sigma G_l.
M3<Pack> geometric_blocks(const M3<Pack>& sigma, const Gradients<Pack>& g) { return mul_bt(mul(g, sigma), g); }

}  // namespace

/// Takes mass times (inertia, and mass damping of the velocities) off the nodal results. Returns its part of motions_.
template <int Order>
Pack ElementSet::add_inertia(const Batch& batch, const Evaluation& e, const std::array<V3<Pack>, ElementOrder<Order>::nodes>& xdot,
                             std::array<V3<Pack>, ElementOrder<Order>::nodes>& nodal) const {
    using O = ElementOrder<Order>;
    constexpr std::size_t nodes = O::nodes;
    const Pack mass = load(batch.mass), mass_damping = load(batch.mass_damping);
    std::array<V3<Pack>, nodes> u;
    for (auto& a : u) a = {Pack(0), Pack(0), Pack(0)};
    if (e.inertia != nullptr) u = gather<O::nodes>(*e.inertia, batch.node);
    if (damped_ && e.velocity != nullptr) {
        for (std::size_t i = 0; i < nodes; ++i)
            for (std::size_t a = 0; a < 3; ++a) u[i][a] += Pack(e.force_scale) * mass_damping * xdot[i][a];
    }
    Pack inertial(0);
    for (std::size_t i = 0; i < nodes; ++i) {
        V3<Pack> impulse = {Pack(0), Pack(0), Pack(0)};
        for (std::size_t j = 0; j < nodes; ++j) {
            const Pack m = mass * Pack(O::mass(static_cast<int>(i), static_cast<int>(j)));
            for (std::size_t a = 0; a < 3; ++a) impulse[a] += m * u[j][a];
        }
        for (std::size_t a = 0; a < 3; ++a) {
            inertial += u[i][a] * impulse[a];
            nodal[i][a] -= impulse[a];
        }
    }
    // u = (v - v0) - h g + h c v has the derivative 1 + h c, c the mass damping.
    return inertial / (Pack(1) + Pack(e.force_scale) * mass_damping);
}

template Pack ElementSet::add_inertia<1>(const Batch&, const Evaluation&, const std::array<V3<Pack>, 4>&, std::array<V3<Pack>, 4>&) const;
template Pack ElementSet::add_inertia<2>(const Batch&, const Evaluation&, const std::array<V3<Pack>, 10>&, std::array<V3<Pack>, 10>&) const;

template <int Order, template <class> class Strain>
void ElementSet::evaluate_batch(std::size_t b, const Evaluation& e) {
    using O = ElementOrder<Order>;
    constexpr std::size_t nodes = O::nodes;
    constexpr double weight = 1.0 / O::points;
    const Batch& batch = batches_[b];

    const auto x = gather<O::nodes>(e.x, batch.node);
    std::array<V3<Pack>, nodes> xdot;
    const bool damped = damped_ && e.velocity != nullptr;
    if (damped) xdot = gather<O::nodes>(*e.velocity, batch.node);
    Gradients<Pack> g;
    for (std::size_t m = 0; m < 9; ++m) g.m[m] = load(batch.gradient[m]);
    const StiffnessInMemory<Pack> c{stiffness_[batch.stiffness].c[0]};
    const Pack volume = load(batch.volume), mass = load(batch.mass);
    const Pack mass_damping = load(batch.mass_damping), stiffness_damping = load(batch.stiffness_damping);
    const Pack stiffness_scale = Pack(e.stiffness_scale) + Pack(e.damping_scale) * stiffness_damping;

    std::array<V3<Pack>, nodes> nodal;
    for (auto& f : nodal) f = {Pack(0), Pack(0), Pack(0)};
    NodeBlocks<Order> tangent;
    std::array<std::array<M3<Pack>, 3>, 3> core;
    if (e.tangent) core = material_blocks(c, g);

    Pack energy(0), motion(0), least(1e300);
    for (int q = 0; q < O::points; ++q) {
        const Strain<Pack> point(deformation_gradient<Order>(x, q, g));
        const Pack orientation = point.orientation();
        least = select(orientation < least, orientation, least);
        const V6<Pack> strain = point.strain();
        V6<Pack> stress = hooke(c, strain);
        energy += Pack(weight) * volume * dot(strain, stress);
        for (std::size_t m = 0; m < 6; ++m)
            store(strain[m], &strains_[((b * O::points + static_cast<std::size_t>(q)) * 6 + m) * pack_size]);
        if (e.tangent) {
            const Pack scale = Pack(weight) * stiffness_scale * volume;
            if constexpr (Strain<Pack>::has_geometric_stress) {
                // Damping has no geometric part: it scales with stiffness_scale alone.
                M3<Pack> geometric = geometric_blocks(point.geometric_stress(stress), g);
                const Pack part = Pack(e.stiffness_scale) / max(stiffness_scale, Pack(1e-300));
                for (Pack& v : geometric.m) v *= part;
                tangent.point(q).set(core, point.frame(), &geometric, scale);
            } else {
                tangent.point(q).set(core, point.frame(), nullptr, scale);
            }
        }
        if (damped) {
            const V6<Pack> rate = strain_rate(point.frame(), deformation_gradient<Order>(xdot, q, g));
            const V6<Pack> viscous = hooke(c, rate);
            motion += Pack(weight * e.force_scale) * volume * stiffness_damping * dot(rate, viscous);
            for (std::size_t m = 0; m < 6; ++m) stress[m] += stiffness_damping * viscous[m];
        }

        const M3<Pack> pg = mul_bt(point.piola(stress), g);  // column k-1: P G_k
        const Pack scale = Pack(-weight * e.force_scale) * volume;
        M3<Pack> corner;
        for (std::size_t m = 0; m < 9; ++m) corner.m[m] = scale * pg.m[m];
        add_corner_forces<Order>(q, corner, nodal);
    }
    store(energy, &energies_[b * pack_size]);
    store(least, &orientation_[b * pack_size]);

    if (e.inertia != nullptr || damped) motion += add_inertia<Order>(batch, e, xdot, nodal);
    store(motion, &motions_[b * pack_size]);
    store_nodal(nodal, &nodal_[b * nodes * nodal_stride * pack_size]);

    if (!e.tangent) return;
    tangent.prepare();
    const Pack block_mass = mass * (Pack(e.mass_scale) + Pack(e.damping_scale) * mass_damping);
    const std::size_t per_element = static_cast<std::size_t>(block_count()) * 9;
    float* out = &blocks_[b * pack_size * per_element];
    for (int i = 0; i < O::nodes; ++i) {
        for (int j = i; j < O::nodes; ++j, out += 9) {
            M3<Pack> block = tangent.block(i, j);
            const Pack m = block_mass * Pack(O::mass(i, j));
            for (std::size_t a = 0; a < 3; ++a) block.m[4 * a] += m;
            scatter_blocks(block, out, per_element);
        }
    }
}

void ElementSet::evaluate(const Evaluation& e) {
    ENSURE(!e.single || (!e.tangent && e.inertia == nullptr), "single precision has neither tangent nor inertia");
    if (e.single) return evaluate_single(e);
    if (e.tangent) blocks_.resize(batches_.size() * pack_size * static_cast<std::size_t>(block_count()) * 9);
    const bool green = strain_measure_ == StrainMeasure::green;
    parallel_for(batches_.size(), batch_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            if (order_ == 1) {
                green ? evaluate_batch<1, GreenPoint>(b, e) : evaluate_batch<1, CorotatedPoint>(b, e);
            } else {
                green ? evaluate_batch<2, GreenPoint>(b, e) : evaluate_batch<2, CorotatedPoint>(b, e);
            }
        }
    });
}

}  // namespace tetfront
