// Forces of all elements in single precision: ElementSet::evaluate_single.
#include <algorithm>

#include "engine/base/parallel.hpp"
#include "engine/mechanics/elements.hpp"
#include "engine/mechanics/gather.hpp"
#include "engine/mechanics/nodal_forces.hpp"
#include "engine/mechanics/strain.hpp"

namespace tetfront {

namespace {
constexpr std::size_t pair_grain = 8;
}

/// Forces and energy of batches 2 `pair` and the next. Strain and stress are in single precision; from the corners' forces on
/// it is double again, so that internal forces still sum to zero.
template <int Order, template <class> class Strain>
void ElementSet::evaluate_pair(std::size_t pair, const Evaluation& e) {
    using O = ElementOrder<Order>;
    const SinglePair& data = single_[pair];
    const std::size_t first = 2 * pair, second = std::min(first + 1, batches_.size() - 1);
    const std::array<const Batch*, 2> batch = {&batches_[first], &batches_[second]};
    const bool damped = damped_ && e.velocity != nullptr;
    const auto x = gather_single<O::nodes>(e.x, batch[0]->node, batch[1]->node);
    std::array<V3<SinglePack>, O::nodes> xdot;
    if (damped) xdot = gather_single<O::nodes>(*e.velocity, batch[0]->node, batch[1]->node);
    Gradients<SinglePack> g;
    for (std::size_t m = 0; m < 9; ++m) g.m[m] = load(data.gradient[m]);
    const StiffnessInMemory<SinglePack> c{single_stiffness_[data.stiffness].c[0]};
    const SinglePack volume = load(data.volume), viscosity = load(data.stiffness_damping);

    std::array<std::array<V3<Pack>, O::nodes>, 2> nodal;
    for (auto& half : nodal)
        for (auto& f : half) f = {Pack(0), Pack(0), Pack(0)};
    const SinglePack scale = constant<SinglePack>(-e.force_scale / O::points) * volume;
    SinglePack energy(0.0F);
    for (int q = 0; q < O::points; ++q) {
        const Strain<SinglePack> point(deformation_gradient<Order>(x, q, g));
        const V6<SinglePack> strain = point.strain();
        V6<SinglePack> stress = hooke(c, strain);
        energy += constant<SinglePack>(1.0 / O::points) * volume * dot(strain, stress);
        if (damped) {
            const V6<SinglePack> viscous = hooke(c, strain_rate(point.frame(), deformation_gradient<Order>(xdot, q, g)));
            for (std::size_t m = 0; m < 6; ++m) stress[m] += viscosity * viscous[m];
        }
        const M3<SinglePack> pg = mul_bt(point.piola(stress), g);
        std::array<M3<Pack>, 2> corner;
        for (std::size_t m = 0; m < 9; ++m) {
            const auto halves = to_double(scale * pg.m[m]);
            for (std::size_t half = 0; half < 2; ++half) corner[half].m[m] = halves[half];
        }
        for (std::size_t half = 0; half < 2; ++half) add_corner_forces<Order>(q, corner[half], nodal[half]);
    }
    const auto energies = to_double(energy);
    for (std::size_t half = 0; half <= second - first; ++half) {
        if (damped) add_inertia<Order>(*batch[half], e, gather<O::nodes>(*e.velocity, batch[half]->node), nodal[half]);
        store(energies[half], &energies_[(first + half) * pack_size]);
        store_nodal(nodal[half], &nodal_[(first + half) * O::nodes * nodal_stride * pack_size]);
    }
}

/// What single precision needs of the batches, once after a build. Pairs of the same materials share them.
void ElementSet::prepare_single() {
    if (!single_.empty()) return;
    single_.resize((batches_.size() + 1) / 2);
    single_stiffness_.clear();
    std::array<std::uint32_t, 2> last{};
    for (std::size_t pair = 0; pair < single_.size(); ++pair) {
        const std::size_t first = 2 * pair, second = std::min(first + 1, batches_.size() - 1);
        SinglePair& data = single_[pair];
        std::array<std::uint32_t, 2> number{};
        for (std::size_t lane = 0; lane < SinglePack::size(); ++lane) {
            const Batch& batch = batches_[lane < pack_size ? first : second];
            const std::size_t l = lane % pack_size;
            for (std::size_t m = 0; m < 9; ++m) data.gradient[m][lane] = static_cast<float>(batch.gradient[m][l]);
            data.volume[lane] = static_cast<float>(batch.volume[l]);
            data.stiffness_damping[lane] = static_cast<float>(batch.stiffness_damping[l]);
            number[lane / pack_size] = batch.stiffness;
        }
        if (pair == 0 || number != last) {
            SingleStiffness& s = single_stiffness_.emplace_back();
            for (std::size_t lane = 0; lane < SinglePack::size(); ++lane)
                for (std::size_t m = 0; m < 21; ++m)
                    s.c[m][lane] = static_cast<float>(stiffness_[number[lane / pack_size]].c[m][lane % pack_size]);
            last = number;
        }
        data.stiffness = static_cast<std::uint32_t>(single_stiffness_.size() - 1);
    }
}

void ElementSet::evaluate_single(const Evaluation& e) {
    prepare_single();
    const bool green = strain_measure_ == StrainMeasure::green;
    parallel_for(single_.size(), pair_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pair = begin; pair < end; ++pair) {
            if (order_ == 1) {
                green ? evaluate_pair<1, GreenPoint>(pair, e) : evaluate_pair<1, CorotatedPoint>(pair, e);
            } else {
                green ? evaluate_pair<2, GreenPoint>(pair, e) : evaluate_pair<2, CorotatedPoint>(pair, e);
            }
        }
    });
}

}  // namespace tetfront
