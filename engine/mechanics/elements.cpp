#include "engine/mechanics/elements.hpp"

#include <algorithm>
#include <numeric>

#include "engine/base/parallel.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace {

constexpr std::size_t batch_grain = 16;

/// Local nodes whose position enters an effective corner: node i contributes `weight` to corner `corner`.
template <int Order>
struct Contributions {
    struct Term {
        int corner;
        double weight;
    };
    std::array<std::array<std::array<Term, 2>, ElementOrder<Order>::nodes>, ElementOrder<Order>::points> terms{};
    std::array<int, ElementOrder<Order>::nodes> count{};

    constexpr Contributions() {
        for (int i = 0; i < ElementOrder<Order>::nodes; ++i) {
            for (int q = 0; q < ElementOrder<Order>::points; ++q) {
                int n = 0;
                for (int k = 0; k < 4; ++k) {
                    const double w = shape_derivative<Order>(q, k, i);
                    if (w != 0) terms[static_cast<std::size_t>(q)][static_cast<std::size_t>(i)][static_cast<std::size_t>(n++)] = {k, w};
                }
                count[static_cast<std::size_t>(i)] = n;
            }
        }
    }
};
template <int Order>
constexpr Contributions<Order> contributions{};

template <int Nodes>
std::array<V3<Pack>, Nodes> gather(const PerVertex<Vec3>& field, const std::int32_t (*node)[pack_size]) {
    std::array<V3<Pack>, Nodes> x;
    for (int i = 0; i < Nodes; ++i) {
        alignas(64) double lanes[3][pack_size];
        for (std::size_t lane = 0; lane < pack_size; ++lane) {
            const Vec3& p = field[VertexId(node[i][lane])];
            for (int c = 0; c < 3; ++c) lanes[c][lane] = p[c];
        }
        for (std::size_t c = 0; c < 3; ++c) x[static_cast<std::size_t>(i)][c] = load(lanes[c]);
    }
    return x;
}

/// The 4x4 blocks of an effective linear tet from the 3x3 rotated material blocks: rows and columns sum to zero.
struct EffectiveBlocks {
    M3<Pack> k[4][4];
};
void rotate_blocks(const std::array<std::array<M3<Pack>, 3>, 3>& a, const M3<Pack>& r, const Pack& scale, EffectiveBlocks& out) {
    for (int k = 0; k < 3; ++k) {
        for (int l = k; l < 3; ++l) {
            M3<Pack>& block = out.k[k + 1][l + 1];
            block = mul_bt(mul(r, a[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)]), r);
            for (Pack& v : block.m) v *= scale;
            if (k == l) continue;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) out.k[l + 1][k + 1](j, i) = block(i, j);
        }
    }
    for (int k = 1; k < 4; ++k) {
        for (std::size_t m = 0; m < 9; ++m) out.k[k][0].m[m] = -(out.k[k][1].m[m] + out.k[k][2].m[m] + out.k[k][3].m[m]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) out.k[0][k](j, i) = out.k[k][0](i, j);
    }
    for (std::size_t m = 0; m < 9; ++m) out.k[0][0].m[m] = -(out.k[1][0].m[m] + out.k[2][0].m[m] + out.k[3][0].m[m]);
}

}  // namespace

void ElementSet::build(const Front& front, const TetMaterials& materials) {
    damped_ = materials.damped();
    const auto damping_of = [](const PerTet<double>& damping, TetId t) { return damping.empty() ? 0 : damping[t]; };
    order_ = front.order();
    tets_ = front.active();
    vertices_ = front.vertices();
    const TetTree& tree = front.tree();
    batches_.resize((tets_.size() + pack_size - 1) / pack_size);
    parallel_for(batches_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            Batch& batch = batches_[b];
            for (std::size_t lane = 0; lane < pack_size; ++lane) {
                const std::size_t e = b * pack_size + lane;
                const bool padding = e >= tets_.size();
                const TetId t = tets_[std::min(e, tets_.size() - 1)];
                const auto node = front.nodes(t);
                for (std::size_t i = 0; i < 10; ++i) batch.node[i][lane] = node[i].value;
                const auto& corner = tree.corners(t);
                const Gradients<double> g = barycentric_gradients(
                    {tree.rest(corner[0]), tree.rest(corner[1]), tree.rest(corner[2]), tree.rest(corner[3])});
                for (std::size_t m = 0; m < 9; ++m) batch.gradient[m][lane] = g.m[m];
                batch.volume[lane] = padding ? 0 : tree.volume(t);
                batch.mass[lane] = padding ? 0 : tree.volume(t) * materials.density[t];
                for (std::size_t m = 0; m < 21; ++m) batch.c[m][lane] = materials.elasticity[t].upper[m];
                batch.mass_damping[lane] = damping_of(materials.mass_damping, t);
                batch.stiffness_damping[lane] = damping_of(materials.stiffness_damping, t);
            }
        }
    });
    const auto n = static_cast<std::size_t>(nodes());
    nodal_.resize(batches_.size() * n * 3 * pack_size);
    strains_.resize(batches_.size() * static_cast<std::size_t>(points()) * 6 * pack_size);
    energies_.assign(batches_.size() * pack_size, 0);
    motions_.assign(batches_.size() * pack_size, 0);
    least_stretch_.assign(batches_.size() * pack_size, 1);

    // Incidence: for each vertex of the front the nodal results that belong to it, in element order.
    slot_.resize(tree.vertex_count());
    for (std::size_t s = 0; s < vertices_.size(); ++s) slot_[vertices_[s]] = static_cast<std::int32_t>(s);
    incidence_begin_.assign(vertices_.size() + 1, 0);
    const auto for_each_node = [&](const auto& visit) {
        for (std::size_t e = 0; e < tets_.size(); ++e) {
            const Batch& batch = batches_[e / pack_size];
            for (std::size_t i = 0; i < n; ++i) {
                visit(static_cast<std::size_t>(slot_[VertexId(batch.node[i][e % pack_size])]),
                      ((e / pack_size * n + i) * 3) * pack_size + e % pack_size);
            }
        }
    };
    for_each_node([&](std::size_t slot, std::size_t) { ++incidence_begin_[slot + 1]; });
    for (std::size_t s = 0; s < vertices_.size(); ++s) incidence_begin_[s + 1] += incidence_begin_[s];
    incidence_.resize(incidence_begin_.back());
    std::vector<std::uint32_t> next(incidence_begin_.begin(), incidence_begin_.end() - 1);
    for_each_node([&](std::size_t slot, std::size_t offset) { incidence_[next[slot]++] = static_cast<std::uint32_t>(offset); });
}

template <int Order>
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
    std::array<Pack, 21> c;
    for (std::size_t m = 0; m < 21; ++m) c[m] = load(batch.c[m]);
    const Pack volume = load(batch.volume), mass = load(batch.mass);
    const Pack mass_damping = load(batch.mass_damping), stiffness_damping = load(batch.stiffness_damping);
    const Pack stiffness_scale = Pack(e.stiffness_scale) + Pack(e.damping_scale) * stiffness_damping;

    std::array<V3<Pack>, nodes> nodal;
    for (auto& f : nodal) f = {Pack(0), Pack(0), Pack(0)};
    std::array<M3<Pack>, nodes*(nodes + 1) / 2> tangent;
    std::array<std::array<M3<Pack>, 3>, 3> core;
    if (e.tangent) {
        for (auto& block : tangent) block = M3<Pack>::zero();
        core = material_blocks(c, g);
    }

    Pack energy(0), motion(0), least(1e300);
    for (int q = 0; q < O::points; ++q) {
        const Svd3<Pack> d = svd3(deformation_gradient<Order>(x, q, g));
        least = select(d.s[2] < least, d.s[2], least);
        const V6<Pack> strain = corotated_strain(d);
        V6<Pack> stress = hooke(c, strain);
        energy += Pack(weight) * volume * dot(strain, stress);
        for (std::size_t m = 0; m < 6; ++m)
            store(strain[m], &strains_[((b * O::points + static_cast<std::size_t>(q)) * 6 + m) * pack_size]);
        const M3<Pack> r = mul_bt(d.u, d.v);
        if (damped) {
            const M3<Pack> rate = mul_at(r, deformation_gradient<Order>(xdot, q, g));
            V6<Pack> strain_rate;
            for (std::size_t m = 0; m < 6; ++m) {
                const auto [i, j] = voigt_pairs[m];
                strain_rate[m] = m < 3 ? rate(i, i) : rate(i, j) + rate(j, i);
            }
            const V6<Pack> viscous = hooke(c, strain_rate);
            motion += Pack(weight * e.force_scale) * volume * stiffness_damping * dot(strain_rate, viscous);
            for (std::size_t m = 0; m < 6; ++m) stress[m] += stiffness_damping * viscous[m];
        }

        // Forces on the effective corners, then on the nodes.
        const M3<Pack> pg = mul_bt(piola_stress(d, stress), g);  // column k-1: P G_k
        const Pack scale = Pack(-weight * e.force_scale) * volume;
        V3<Pack> corner[4];
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 1; k < 4; ++k) corner[k][i] = scale * pg.m[3 * i + k - 1];
            corner[0][i] = -(corner[1][i] + corner[2][i] + corner[3][i]);
        }
        const auto& terms = contributions<Order>.terms[static_cast<std::size_t>(q)];
        for (std::size_t i = 0; i < nodes; ++i) {
            for (int n = 0; n < contributions<Order>.count[i]; ++n) {
                const auto& term = terms[i][static_cast<std::size_t>(n)];
                for (std::size_t a = 0; a < 3; ++a) nodal[i][a] += Pack(term.weight) * corner[term.corner][a];
            }
        }
        if (!e.tangent) continue;
        EffectiveBlocks effective;
        rotate_blocks(core, r, Pack(weight) * stiffness_scale * volume, effective);
        std::size_t block = 0;
        for (std::size_t i = 0; i < nodes; ++i) {
            for (std::size_t j = i; j < nodes; ++j, ++block) {
                for (int n = 0; n < contributions<Order>.count[i]; ++n) {
                    for (int m = 0; m < contributions<Order>.count[j]; ++m) {
                        const auto &ti = terms[i][static_cast<std::size_t>(n)], &tj = terms[j][static_cast<std::size_t>(m)];
                        const Pack w(ti.weight * tj.weight);
                        const M3<Pack>& k = effective.k[ti.corner][tj.corner];
                        for (std::size_t a = 0; a < 9; ++a) tangent[block].m[a] += w * k.m[a];
                    }
                }
            }
        }
    }
    store(energy, &energies_[b * pack_size]);
    store(least, &least_stretch_[b * pack_size]);

    if (e.inertia != nullptr || damped) {
        std::array<V3<Pack>, nodes> u;
        for (auto& a : u) a = {Pack(0), Pack(0), Pack(0)};
        if (e.inertia != nullptr) u = gather<O::nodes>(*e.inertia, batch.node);
        if (damped) {
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
        motion += inertial / (Pack(1) + Pack(e.force_scale) * mass_damping);
    }
    store(motion, &motions_[b * pack_size]);
    for (std::size_t i = 0; i < nodes; ++i)
        for (std::size_t a = 0; a < 3; ++a) store(nodal[i][a], &nodal_[((b * nodes + i) * 3 + a) * pack_size]);

    if (!e.tangent) return;
    const Pack mass_scale = Pack(e.mass_scale) + Pack(e.damping_scale) * mass_damping;
    float* out = &blocks_[b * tangent.size() * 9 * pack_size];
    std::size_t block = 0;
    for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t j = i; j < nodes; ++j, ++block) {
            const Pack m = mass * mass_scale * Pack(O::mass(static_cast<int>(i), static_cast<int>(j)));
            for (std::size_t a = 0; a < 3; ++a) tangent[block].m[4 * a] += m;
            for (std::size_t a = 0; a < 9; ++a) {
                alignas(64) double lanes[pack_size];
                store(tangent[block].m[a], lanes);
                for (std::size_t lane = 0; lane < pack_size; ++lane)
                    out[(block * 9 + a) * pack_size + lane] = static_cast<float>(lanes[lane]);
            }
        }
    }
}

void ElementSet::evaluate(const Evaluation& e) {
    if (e.tangent) blocks_.resize(batches_.size() * static_cast<std::size_t>(block_count()) * 9 * pack_size);
    parallel_for(batches_.size(), batch_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            if (order_ == 1) {
                evaluate_batch<1>(b, e);
            } else {
                evaluate_batch<2>(b, e);
            }
        }
    });
}

void ElementSet::accumulate(PerVertex<Vec3>& f) const {
    parallel_for(vertices_.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            Vec3 sum = Vec3::Zero();
            for (std::uint32_t n = incidence_begin_[s]; n < incidence_begin_[s + 1]; ++n) {
                const double* p = &nodal_[incidence_[n]];
                sum += Vec3(p[0], p[pack_size], p[2 * pack_size]);
            }
            f[vertices_[s]] = sum;
        }
    });
}

double ElementSet::energy() const {
    double twice = 0;
    for (double e : energies_) twice += e;
    return twice / 2;
}

double ElementSet::potential() const {
    double twice = 0;
    for (double m : motions_) twice += m;
    return energy() + twice / 2;
}

int ElementSet::inverted() const {
    return static_cast<int>(std::count_if(least_stretch_.begin(), least_stretch_.begin() + static_cast<std::ptrdiff_t>(size()),
                                          [](double s) { return !(s > 0); }));
}

Vec6 ElementSet::strain(std::size_t e, int point) const {
    Vec6 s;
    const std::size_t first =
        (e / pack_size * static_cast<std::size_t>(points()) + static_cast<std::size_t>(point)) * 6 * pack_size + e % pack_size;
    for (std::size_t m = 0; m < 6; ++m) s[static_cast<int>(m)] = strains_[first + m * pack_size];
    return s;
}

double ElementSet::mass() const {
    double sum = 0;
    for (const Batch& b : batches_)
        for (double m : b.mass) sum += m;
    return sum;
}

namespace {
template <int Order, class Visit>
void visit_mass(const Visit& visit) {
    for (int i = 0; i < ElementOrder<Order>::nodes; ++i)
        for (int j = 0; j < ElementOrder<Order>::nodes; ++j) visit(i, j, ElementOrder<Order>::mass(i, j));
}
}  // namespace

ElementSet::Momentum ElementSet::momentum(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) const {
    Momentum p{Vec3::Zero(), Vec3::Zero()};
    for (std::size_t e = 0; e < size(); ++e) {
        const Batch& batch = batches_[e / pack_size];
        const std::size_t lane = e % pack_size;
        const auto add = [&](int i, int j, double m) {
            const Vec3 mv = m * batch.mass[lane] * v[VertexId(batch.node[j][lane])];
            p.linear += mv;
            p.angular += x[VertexId(batch.node[i][lane])].cross(mv);
        };
        order_ == 1 ? visit_mass<1>(add) : visit_mass<2>(add);
    }
    return p;
}

Vec3 ElementSet::first_moment(const PerVertex<Vec3>& x) const {
    // Row sums of the mass matrix: 1/4 each; order 2: -1/20 at corners, 1/5 at midpoints.
    Vec3 sum = Vec3::Zero();
    for (std::size_t e = 0; e < size(); ++e) {
        const Batch& batch = batches_[e / pack_size];
        const std::size_t lane = e % pack_size;
        Vec3 corners = Vec3::Zero(), midpoints = Vec3::Zero();
        for (std::size_t i = 0; i < 4; ++i) corners += x[VertexId(batch.node[i][lane])];
        for (std::size_t i = 4; i < static_cast<std::size_t>(nodes()); ++i) midpoints += x[VertexId(batch.node[i][lane])];
        sum += batch.mass[lane] * (order_ == 1 ? Vec3(corners / 4) : Vec3(midpoints / 5 - corners / 20));
    }
    return sum;
}

template <int Order>
double ElementSet::kinetic_energy_of(const PerVertex<Vec3>& v) const {
    constexpr std::size_t nodes = ElementOrder<Order>::nodes;
    std::vector<double> twice(batches_.size());
    parallel_for(batches_.size(), batch_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const auto u = gather<ElementOrder<Order>::nodes>(v, batches_[b].node);
            Pack sum(0);
            for (std::size_t i = 0; i < nodes; ++i) {
                V3<Pack> mu = {Pack(0), Pack(0), Pack(0)};
                for (std::size_t j = 0; j < nodes; ++j) {
                    const Pack m(ElementOrder<Order>::mass(static_cast<int>(i), static_cast<int>(j)));
                    for (std::size_t a = 0; a < 3; ++a) mu[a] += m * u[j][a];
                }
                for (std::size_t a = 0; a < 3; ++a) sum += u[i][a] * mu[a];
            }
            alignas(64) double lanes[pack_size];
            store(sum * load(batches_[b].mass), lanes);
            twice[b] = std::accumulate(lanes, lanes + pack_size, 0.0);
        }
    });
    return std::accumulate(twice.begin(), twice.end(), 0.0) / 2;
}

double ElementSet::kinetic_energy(const PerVertex<Vec3>& v) const {
    return order_ == 1 ? kinetic_energy_of<1>(v) : kinetic_energy_of<2>(v);
}

}  // namespace tetfront
