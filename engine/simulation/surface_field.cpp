#include "engine/simulation/surface_field.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "engine/base/parallel.hpp"
#include "engine/base/voigt.hpp"

namespace tetfront {

namespace {

/// Equivalent strain sqrt(2/3 e':e'), e' the deviator.
double equivalent_strain(const Vec6& strain) {
    const Mat3 e = strain_tensor(strain);
    return std::sqrt(2.0 / 3) * (e - e.trace() / 3 * Mat3::Identity()).norm();
}

/// Von Mises stress sqrt(3/2 s':s') [Pa].
double von_mises(const Vec6& stress) {
    const Mat3 s = stress_tensor(stress);
    return std::sqrt(1.5) * (s - s.trace() / 3 * Mat3::Identity()).norm();
}

/// [V of the tree], of which only the front's entries are ever touched: costs what the front costs.
using Sparse = std::unique_ptr<double[]>;
Sparse zero_on_front(const Front& front) {
    Sparse values = std::make_unique_for_overwrite<double[]>(front.tree().vertex_count());
    for (const VertexId v : front.vertices()) values[v.index()] = 0;
    return values;
}

double distance(const std::array<float, 3>& p, const Vec3& q) {
    return (Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])) - q).norm();
}

/// value(e, corner) of each active tet, averaged at the corners by volume; NaN at vertices that are no corners.
template <class Value>
Sparse corner_average(const FieldSource& s, const Value& value) {
    const TetTree& tree = s.front.tree();
    Sparse sum = zero_on_front(s.front), weight = zero_on_front(s.front);
    const auto& tets = s.elements.tets();
    for (std::size_t e = 0; e < tets.size(); ++e) {
        const double volume = tree.volume(tets[e]);
        const auto& corners = tree.corners(tets[e]);
        for (int k = 0; k < 4; ++k) {
            const std::size_t v = corners[static_cast<std::size_t>(k)].index();
            sum[v] += volume * value(e, k);
            weight[v] += volume;
        }
    }
    for (const VertexId v : s.front.vertices()) sum[v.index()] /= weight[v.index()];
    return sum;
}

}  // namespace

float field_high(std::vector<float> values) {
    std::erase_if(values, [](float x) { return !std::isfinite(x); });
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * 98 / 100);
    std::ranges::nth_element(values, at);
    return *at;
}

FieldValues surface_field(Field field, const FieldSource& s) {
    FieldValues all;
    if (field == Field::none) return all;
    std::vector<float>& values = all.surface;
    values.resize(s.points.size());
    all.front.resize(s.front.vertices().size());
    if (field == Field::displacement) {
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(distance(s.positions[i], s.surface.mesh.positions[i]));
        for (std::size_t i = 0; i < all.front.size(); ++i)
            all.front[i] = static_cast<float>(distance(s.front_positions[i], s.front.tree().rest(s.front.vertices()[i])));
        return all;
    }
    const auto& tets = s.elements.tets();
    // Point k of a quadratic tet is the one near corner k; a linear tet has one for all.
    const auto strain = [&](std::size_t e, int corner) { return s.elements.strain(e, s.elements.points() == 4 ? corner : 0); };
    Sparse nodal;
    if (field == Field::strain) {
        nodal = corner_average(s, [&](std::size_t e, int k) { return equivalent_strain(strain(e, k)); });
    } else if (field == Field::stress) {
        nodal = corner_average(s, [&](std::size_t e, int k) {
            return von_mises(s.matrices.elasticity[tets[e]].matrix() * strain(e, k));
        });
    } else {
        const std::vector<double>& eta2 = s.adaptivity.indicators();
        const double total = std::accumulate(eta2.begin(), eta2.end(), 0.0);
        const double scale = total > 0 ? s.adaptivity.estimate() / total : 0;
        nodal = corner_average(s, [&](std::size_t e, int) { return scale * eta2[e]; });
    }
    parallel_for(values.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Front::Point& point = s.points[i];
            double value = 0;
            for (int k = 0; k < 4; ++k) value += point.barycentric[k] * nodal[point.nodes[static_cast<std::size_t>(k)].index()];
            values[i] = static_cast<float>(std::isfinite(value) ? std::max(0.0, value) : 0.0);
        }
    });
    if (s.front.order() == 2) {
        for (const TetId t : s.front.active()) {
            const auto node = s.front.nodes(t);
            for (std::size_t e = 0; e < 6; ++e) {
                double& middle = nodal[node[4 + e].index()];
                if (!std::isnan(middle)) continue;  // a corner of a finer tet, or done
                middle = (nodal[node[static_cast<std::size_t>(tet_edges[e][0])].index()] +
                          nodal[node[static_cast<std::size_t>(tet_edges[e][1])].index()]) / 2;
            }
        }
    }
    for (std::size_t i = 0; i < all.front.size(); ++i) {
        const double value = nodal[s.front.vertices()[i].index()];
        all.front[i] = static_cast<float>(std::isfinite(value) ? std::max(0.0, value) : 0.0);
    }
    return all;
}

}  // namespace tetfront
