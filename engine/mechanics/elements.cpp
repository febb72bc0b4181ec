#include "engine/mechanics/elements.hpp"

#include <algorithm>
#include <numeric>

#include "engine/base/parallel.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/mechanics/gather.hpp"
#include "engine/mechanics/nodal_forces.hpp"

namespace tetfront {

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
                batch.mass_damping[lane] = damping_of(materials.mass_damping, t);
                batch.stiffness_damping[lane] = damping_of(materials.stiffness_damping, t);
            }
        }
    });
    pool_stiffness(materials.elasticity);
    const bool single = !single_.empty();
    single_.clear();
    if (single) prepare_single();
    const auto n = static_cast<std::size_t>(nodes());
    nodal_.resize(batches_.size() * n * nodal_stride * pack_size);
    strains_.resize(batches_.size() * static_cast<std::size_t>(points()) * 6 * pack_size);
    energies_.assign(batches_.size() * pack_size, 0);
    motions_.assign(batches_.size() * pack_size, 0);
    orientation_.assign(batches_.size() * pack_size, 1);

    // Incidence: for each vertex of the front the nodal results that belong to it, in element order.
    slot_.resize(tree.vertex_count());
    for (std::size_t s = 0; s < vertices_.size(); ++s) slot_[vertices_[s]] = static_cast<std::int32_t>(s);
    incidence_begin_.assign(vertices_.size() + 1, 0);
    const auto for_each_node = [&](const auto& visit) {
        for (std::size_t e = 0; e < tets_.size(); ++e) {
            const Batch& batch = batches_[e / pack_size];
            for (std::size_t i = 0; i < n; ++i) {
                visit(static_cast<std::size_t>(slot_[VertexId(batch.node[i][e % pack_size])]),
                      ((e / pack_size * n + i) * pack_size + e % pack_size) * nodal_stride);
            }
        }
    };
    for_each_node([&](std::size_t slot, std::size_t) { ++incidence_begin_[slot + 1]; });
    for (std::size_t s = 0; s < vertices_.size(); ++s) incidence_begin_[s + 1] += incidence_begin_[s];
    incidence_.resize(incidence_begin_.back());
    std::vector<std::uint32_t> next(incidence_begin_.begin(), incidence_begin_.end() - 1);
    for_each_node([&](std::size_t slot, std::size_t offset) { incidence_[next[slot]++] = static_cast<std::uint32_t>(offset); });
}

/// Consecutive batches of the same materials share one entry: for a uniform object a batch is half as large.
void ElementSet::pool_stiffness(const PooledPerTet<Sym6>& elasticity) {
    stiffness_.clear();
    std::array<std::uint32_t, pack_size> last{};
    for (std::size_t b = 0; b < batches_.size(); ++b) {
        std::array<std::uint32_t, pack_size> number;
        for (std::size_t lane = 0; lane < pack_size; ++lane)
            number[lane] = elasticity.numbers()[tets_[std::min(b * pack_size + lane, tets_.size() - 1)].index()];
        if (b == 0 || number != last) {
            BatchStiffness& s = stiffness_.emplace_back();
            for (std::size_t lane = 0; lane < pack_size; ++lane)
                for (std::size_t m = 0; m < 21; ++m) s.c[m][lane] = elasticity.values()[number[lane]].upper[m];
            last = number;
        }
        batches_[b].stiffness = static_cast<std::uint32_t>(stiffness_.size() - 1);
    }
}

void ElementSet::accumulate(PerVertex<Vec3>& f) const {
    parallel_for(vertices_.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            Vec4 sum = Vec4::Zero();
            for (std::uint32_t n = incidence_begin_[s]; n < incidence_begin_[s + 1]; ++n) sum += Eigen::Map<const Vec4>(&nodal_[incidence_[n]]);
            f[vertices_[s]] = sum.head<3>();
        }
    });
}

namespace {
/// In several partial sums, so that additions need not wait for each other. (Eigen's sums depend on where memory is aligned.)
double sum_of_lanes(const std::vector<double>& values) {
    std::array<Pack, 4> sums;
    sums.fill(Pack(0));
    for (std::size_t i = 0; i < values.size(); i += pack_size) sums[i / pack_size % sums.size()] += load(&values[i]);
    return std::experimental::reduce((sums[0] + sums[1]) + (sums[2] + sums[3]));
}
}  // namespace

double ElementSet::energy() const { return sum_of_lanes(energies_) / 2; }
double ElementSet::potential() const { return energy() + sum_of_lanes(motions_) / 2; }

int ElementSet::inverted() const {
    return static_cast<int>(std::count_if(orientation_.begin(), orientation_.begin() + static_cast<std::ptrdiff_t>(size()),
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

Momentum ElementSet::momentum(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) const {
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
    const double twice = parallel_sum(batches_.size(), 16, [&](std::size_t begin, std::size_t end) {
        double total = 0;
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
            total += std::accumulate(lanes, lanes + pack_size, 0.0);
        }
        return total;
    });
    return twice / 2;
}

double ElementSet::kinetic_energy(const PerVertex<Vec3>& v) const {
    return order_ == 1 ? kinetic_energy_of<1>(v) : kinetic_energy_of<2>(v);
}

}  // namespace tetfront
