#include "engine/mechanics/explicit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace {

/// Of the stable substep at rest; turning and stretching change it a little.
constexpr double safety = 0.85;
/// Root mean square of the strain from which on forces may be off by 1e-7 of the stiffness.
constexpr double strain_for_single = 1e-3;
/// A lumped mass is never less than this part of what it would be without the negative weights.
constexpr double least_mass_part = 0.25;

/// Part of a tet's mass that node i gets: order 2 as lumped over the eight children.
double lumped_mass(int order, std::size_t i) { return order == 1 ? 0.25 : i < 4 ? 1.0 / 32 : 7.0 / 48; }

template <int Order>
double largest_frequency2_of(const Gradients<double>& g, const Sym6& c, double density) {
    using O = ElementOrder<Order>;
    constexpr int n = O::nodes;
    Eigen::Matrix<double, 6, 6> stiffness;
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) stiffness(i, j) = c(i, j);
    Eigen::Matrix<double, 3 * n, 3 * n> k = Eigen::Matrix<double, 3 * n, 3 * n>::Zero();  // per volume, mass-scaled
    for (int q = 0; q < O::points; ++q) {
        Eigen::Matrix<double, 6, 3 * n> b = Eigen::Matrix<double, 6, 3 * n>::Zero();
        for (int i = 0; i < n; ++i) {
            Vec3 d = Vec3::Zero();  // gradient of node i's shape function
            for (int corner = 0; corner < 4; ++corner) {
                const double w = shape_derivative<Order>(q, corner, i);
                for (int a = 0; a < 3; ++a) d[a] += w * (corner == 0 ? -(g(0, a) + g(1, a) + g(2, a)) : g(corner - 1, a));
            }
            d /= std::sqrt(density * lumped_mass(Order, static_cast<std::size_t>(i)));
            for (int a = 0; a < 3; ++a) b(a, 3 * i + a) = d[a];
            b(3, 3 * i + 1) = b(4, 3 * i) = d[2];
            b(3, 3 * i + 2) = b(5, 3 * i) = d[1];
            b(4, 3 * i + 2) = b(5, 3 * i + 1) = d[0];
        }
        k += b.transpose() * stiffness * b / O::points;
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 3 * n, 3 * n>>(k, Eigen::EigenvaluesOnly).eigenvalues()[3 * n - 1];
}

}  // namespace

double largest_frequency2(int order, const std::array<Vec3, 4>& corners, const Sym6& c, double density) {
    const Gradients<double> g = barycentric_gradients(corners);
    return order == 1 ? largest_frequency2_of<1>(g, c, density) : largest_frequency2_of<2>(g, c, density);
}

/// Masses of the free vertices, and how much hanging rows raise frequencies at most. With S_v = sum_i |w_vi| for the row of v,
/// Cauchy and Schwarz give x^T P^T m P x <= sum_i x_i^2 sum_v m_v S_v |w_vi|.
void Explicit::lump(const Front& front, const TetMaterials& materials) {
    const TetTree& tree = front.tree();
    for (VertexId v : front.vertices()) {
        mass_[v] = 0;
        weight_sum_[v] = 1;
    }
    const auto nodes = static_cast<std::size_t>(front.nodes_per_tet());
    for (TetId t : front.active()) {
        const auto node = front.nodes(t);
        for (std::size_t i = 0; i < nodes; ++i) mass_[node[i]] += tree.volume(t) * materials.density[t] * lumped_mass(front.order(), i);
    }
    for (VertexId v : front.hanging()) {
        const TetTree::Row row = tree.row(front.order(), v);
        weight_sum_[v] = 0;
        for (std::size_t k = 0; k < row.vertices.size(); ++k) weight_sum_[v] += std::abs(row.weights[k]) * weight_sum_[row.vertices[k]];
    }
    for (VertexId v : front.vertices()) spread_[v] = mass_[v] * weight_sum_[v];
    front.restrict_to_free(mass_);
    for (auto v = front.hanging().rbegin(); v != front.hanging().rend(); ++v) {
        const TetTree::Row row = tree.row(front.order(), *v);
        for (std::size_t k = 0; k < row.vertices.size(); ++k) spread_[row.vertices[k]] += std::abs(row.weights[k]) * spread_[*v];
    }
    amplification_ = 1;
    for (VertexId v : moving_) {
        mass_[v] = std::max(mass_[v], least_mass_part * spread_[v]);
        amplification_ = std::max(amplification_, spread_[v] / mass_[v]);
    }
}

void Explicit::build(const Front& front, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned) {
    const TetTree& tree = front.tree();
    const std::size_t n = tree.vertex_count();
    for (PerVertex<double>* field : {&mass_, &spread_, &weight_sum_}) field->resize(n);
    nodal_.resize(n);
    moves_.resize(n);
    frequency2_.resize(tree.tet_count());
    moving_.clear();
    for (VertexId v : front.vertices()) {
        moves_[v] = front.state(v) == VertexState::free && !pinned[v];
        if (moves_[v]) moving_.push_back(v);
    }
    lump(front, materials);
    stable_step_ = 1e300;
    stiffness_ = 0;
    const auto damping_of = [](const PerTet<double>& damping, TetId t) { return damping.empty() ? 0 : damping[t]; };
    for (TetId t : front.active()) {
        stiffness_ += tree.volume(t) * materials.elasticity[t](0, 0);
        float& w2 = frequency2_[t];
        if (w2 == 0) {
            const auto& c = tree.corners(t);
            w2 = static_cast<float>(largest_frequency2(front.order(), {tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3])},
                                                       materials.elasticity[t], materials.density[t]));
        }
        const double w = std::sqrt(amplification_ * static_cast<double>(w2));
        const double z = (damping_of(materials.mass_damping, t) / w + damping_of(materials.stiffness_damping, t) * w) / 2;
        stable_step_ = std::min(stable_step_, safety * 2 / (w * (std::sqrt(1 + z * z) + z)));
    }
}

double Explicit::substeps(double time_step) const { return std::max(1.0, std::ceil(time_step / stable_step_)); }

void Explicit::add_free_weights(const Front& front, const Front::Point& at) {
    const std::size_t begin = weights_.size();
    for (std::size_t i = 0; i < static_cast<std::size_t>(front.nodes_per_tet()); ++i) weights_.push_back({at.nodes[i], at.weights[i]});
    for (std::size_t i = begin; i < weights_.size(); ++i) {  // rows may point to hanging vertices in turn
        const FreeWeight w = weights_[i];
        if (front.state(w.vertex) != VertexState::hanging) continue;
        const TetTree::Row row = front.tree().row(front.order(), w.vertex);
        for (std::size_t k = 0; k < row.vertices.size(); ++k) weights_.push_back({row.vertices[k], w.weight * row.weights[k]});
        weights_[i].weight = 0;
    }
    // One entry for each vertex that moves.
    std::sort(weights_.begin() + static_cast<std::ptrdiff_t>(begin), weights_.end(),
              [](const FreeWeight& a, const FreeWeight& b) { return a.vertex < b.vertex; });
    std::size_t end = begin;
    for (std::size_t i = begin; i < weights_.size(); ++i) {
        if (weights_[i].weight == 0) continue;
        if (end > begin && weights_[end - 1].vertex == weights_[i].vertex) {
            weights_[end - 1].weight += weights_[i].weight;
        } else {
            weights_[end++] = weights_[i];
        }
    }
    weights_.resize(end);
    weights_end_.push_back(end);
}

Explicit::PointMotion Explicit::motion_of(std::size_t begin, std::size_t end, const State& state) const {
    PointMotion motion{Vec3::Zero(), Vec3::Zero(), 0};
    for (std::size_t i = begin; i < end; ++i) {
        const auto& [v, w] = weights_[i];
        motion.x += w * state.x[v];
        motion.v += w * state.v[v];
        if (moves_[v]) motion.mobility += w * w / mass_[v];
    }
    return motion;
}

void Explicit::push(std::size_t begin, std::size_t end, const Vec3& impulse, State& state) const {
    for (std::size_t i = begin; i < end; ++i)
        if (const auto& [v, w] = weights_[i]; moves_[v]) state.v[v] += w / mass_[v] * impulse;
}

/// One impulse j for each spring, backward Euler for it alone: j = d (k (target - x - d u) - c u), u the velocity after it.
void Explicit::apply_springs(const Loads& loads, State& state, double d) {
    std::size_t begin = 0;
    for (std::size_t s = 0; s < loads.springs.size(); ++s) {
        const PointSpring& spring = loads.springs[s];
        const PointMotion point = motion_of(begin, weights_end_[s], state);
        const double resistance = d * (spring.damping + d * spring.stiffness);
        const Vec3 impulse =
            (d * spring.stiffness * (spring.target - point.x) - resistance * point.v) / (1 + point.mobility * resistance);
        push(begin, weights_end_[s], impulse, state);
        begin = weights_end_[s];
    }
}

/// The same for contacts, one after another: an impulse along the normal that never pulls, and one that stops the sliding as far
/// as friction reaches.
void Explicit::apply_contacts(const Loads& loads, State& state, double d) {
    for (std::size_t c = 0; c < loads.contacts.size(); ++c) {
        const PointContact& contact = loads.contacts[c];
        const std::size_t s = loads.springs.size() + c, begin = s == 0 ? 0 : weights_end_[s - 1];
        const PointMotion point = motion_of(begin, weights_end_[s], state);
        const double depth = contact.depth(point.x);
        if (!(depth > 0) || !(point.mobility > 0)) continue;
        const double resistance = d * d * contact.push_slope(depth);
        const double press =
            std::max(0.0, (d * contact.push(depth) - resistance * contact.normal.dot(point.v)) / (1 + point.mobility * resistance));
        const Vec3 stop = -contact.along(point.v) / point.mobility;
        const double most = contact.friction * press, needed = stop.norm();
        push(begin, weights_end_[s], press * contact.normal + (needed > most ? Vec3(most / needed * stop) : stop), state);
    }
}

ExplicitReport Explicit::step(const Front& front, ElementSet& elements, State& state, const Loads& loads, double time_step, int refine) {
    ExplicitReport report;
    report.substeps = static_cast<int>(substeps(time_step * refine));
    const double d = time_step / report.substeps;
    const int nodes = front.nodes_per_tet();
    const bool strained = 2 * elements.energy() > strain_for_single * strain_for_single * stiffness_;
    weights_.clear();
    weights_end_.clear();
    for (const PointSpring& spring : loads.springs) add_free_weights(front, spring.at);
    for (const PointContact& contact : loads.contacts) add_free_weights(front, contact.at);
    for (VertexId v : front.vertices()) {
        state.earlier_x[v] = state.x[v];
        state.earlier_v[v] = state.v[v];
    }
    for (int n = 0; n < report.substeps; ++n) {
        for (VertexId v : front.vertices()) state.x[v] += d * state.v[v];
        // The last one leaves the strains of the state.
        elements.evaluate({.x = state.x, .velocity = &state.v, .single = strained && n + 1 < report.substeps});
        elements.accumulate(nodal_);
        for (const PointForce& f : loads.forces) add_at(f.at, nodes, f.force, nodal_);
        front.restrict_to_free(nodal_);
        for (VertexId v : moving_) state.v[v] += d * (nodal_[v] / mass_[v] + loads.gravity);
        apply_springs(loads, state, d);
        apply_contacts(loads, state, d);
        front.prolong(state.v);
        if (!std::isfinite(elements.energy())) break;
    }
    report.finite = std::isfinite(elements.energy());
    for (VertexId v : front.vertices()) {
        report.finite = report.finite && state.x[v].allFinite() && state.v[v].allFinite();
        state.a[v] = (state.v[v] - state.earlier_v[v]) / time_step;
    }
    state.has_earlier = true;
    return report;
}

}  // namespace tetfront
