#include "engine/mechanics/implicit.hpp"

#include <chrono>
#include <cmath>

#include "engine/base/parallel.hpp"

namespace tetfront {

namespace {

class Stopwatch {
 public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
        return ms;
    }

 private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

void Implicit::build(const Front& front, const ElementSet& elements, const TetMaterials& materials,
                     const PerVertex<std::uint8_t>& pinned) {
    matrix_.build(front, elements, pinned);
    preconditioner_.build(front, materials, pinned, matrix_);
    const std::size_t n = front.tree().vertex_count();
    for (PerVertex<Vec3>* field : {&trial_x_, &trial_v_, &inertia_, &nodal_}) field->resize(n);
    fixed_.clear();
    for (VertexId v : front.vertices())
        if (front.state(v) == VertexState::free && pinned[v]) fixed_.push_back(v);
    right_.resize(matrix_.size());
    update_.resize(matrix_.size());
}

/// Positions and the hanging vertices that belong to the trial velocity.
void Implicit::set_trial(const Front& front, const State& state, double h) {
    for (VertexId v : fixed_) trial_v_[v].setZero();
    front.prolong(trial_v_);
    for (VertexId v : front.vertices()) trial_x_[v] = state.x[v] + h * trial_v_[v];
}

/// Fills right_ with minus the residual and the tangent of the trial state; returns the norm of the internal impulses,
/// against which a residual counts as small.
double Implicit::residual(const Front& front, ElementSet& elements, const State& state, const Loads& loads, double h) {
    for (VertexId v : front.vertices()) inertia_[v] = (trial_v_[v] - state.v[v]) - h * loads.gravity;
    elements.evaluate({.x = trial_x_,
                       .force_scale = h,
                       .inertia = &inertia_,
                       .velocity = &trial_v_,
                       .tangent = true,
                       .stiffness_scale = h * h,
                       .mass_scale = 1,
                       .damping_scale = h});
    elements.accumulate(nodal_);
    const int nodes = front.nodes_per_tet();
    for (const PointForce& f : loads.forces) add_at(f.at, nodes, h * f.force, nodal_);
    for (const PointSpring& p : loads.springs) {
        const Vec3 force = p.stiffness * (p.target - value_at(p.at, nodes, trial_x_)) - p.damping * value_at(p.at, nodes, trial_v_);
        add_at(p.at, nodes, h * force, nodal_);
    }
    front.restrict_to_free(nodal_);
    const auto& vertex = matrix_.vertices();
    for (std::size_t i = 0; i < vertex.size(); ++i) right_[i] = nodal_[vertex[i]];
    double sum = 0;
    for (const Vec3& r : right_) sum += r.squaredNorm();
    return std::sqrt(sum);
}

ImplicitReport Implicit::step(const Front& front, ElementSet& elements, State& state, const Loads& loads,
                              const ImplicitSettings& settings) {
    ImplicitReport report;
    const double h = settings.midpoint ? settings.time_step / 2 : settings.time_step;
    const int nodes = front.nodes_per_tet();
    Stopwatch watch;
    for (VertexId v : front.vertices()) trial_v_[v] = state.v[v];
    set_trial(front, state, h);
    double first_norm = 0;
    for (int iteration = 0;; ++iteration) {
        const double norm = residual(front, elements, state, loads, h);
        if (!std::isfinite(norm)) {
            report.finite = report.converged = false;
            break;
        }
        if (iteration == 0) first_norm = norm;
        const bool done = norm <= settings.newton_tolerance * first_norm;
        if (norm == 0 || (iteration > 0 && done)) break;
        if (iteration == settings.newton_iterations) {
            report.converged = false;
            break;
        }
        matrix_.fill(elements);
        for (const PointSpring& p : loads.springs) {
            matrix_.add_point({p.at.nodes.data(), static_cast<std::size_t>(nodes)}, {p.at.weights.data(), static_cast<std::size_t>(nodes)},
                              h * h * p.stiffness + h * p.damping);
        }
        preconditioner_.update(matrix_, h * h, 1, h);
        report.assemble_milliseconds += watch.lap();

        const auto& vertex = matrix_.vertices();
        for (std::size_t i = 0; i < vertex.size(); ++i)
            update_[i] = iteration == 0 ? Vec3(h * state.a[vertex[i]]) : Vec3::Zero();
        const PcgResult solved = pcg_.solve(matrix_, preconditioner_, right_, update_, settings.pcg);
        report.converged = report.converged && solved.converged;
        report.solver_iterations += solved.iterations;
        report.residual = solved.residual;
        ++report.newton_iterations;
        for (std::size_t i = 0; i < vertex.size(); ++i) trial_v_[vertex[i]] += update_[i];
        set_trial(front, state, h);
        report.solve_milliseconds += watch.lap();
        if (settings.newton_iterations == 1) break;
    }
    if (!report.finite) return report;

    if (settings.midpoint) {
        for (VertexId v : front.vertices()) {
            trial_v_[v] = 2 * trial_v_[v] - state.v[v];
            trial_x_[v] = 2 * trial_x_[v] - state.x[v];
        }
    }
    elements.evaluate({.x = trial_x_});
    report.finite = std::isfinite(elements.energy());
    for (VertexId v : front.vertices()) report.finite = report.finite && trial_x_[v].allFinite() && trial_v_[v].allFinite();
    if (report.finite) {
        for (VertexId v : front.vertices()) {
            state.a[v] = (trial_v_[v] - state.v[v]) / settings.time_step;
            state.x[v] = trial_x_[v];
            state.v[v] = trial_v_[v];
        }
    }
    report.assemble_milliseconds += watch.lap();
    return report;
}

}  // namespace tetfront
