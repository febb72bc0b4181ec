#include "engine/mechanics/implicit.hpp"

#include <algorithm>
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


double dot(const DofVector& a, const DofVector& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
}

/// A linearised step that is not sound goes on until the residual has fallen to this part, or so many times.
constexpr double rescue_tolerance = 1e-2;
constexpr int rescue_iterations = 30;
/// One that touches the ground so many times, with linear solves to this; then it has to be sound only, as a linearised one.
constexpr int contact_iterations = 12;
constexpr double contact_forcing = 1e-2;
/// Armijo's condition, and the curvature that is good enough where there is no exact potential.
constexpr double least_decrease = 1e-4, enough_flattening = 0.5;
constexpr double potential_rounding = 1e-12;
constexpr int most_cuts = 20;
/// A sound update that would have to be cut to less than this part is taken as it is.
constexpr double shortest_before_stuck = 0.05;

}  // namespace

bool Implicit::Trial::finite() const { return std::isfinite(potential) && std::isfinite(norm); }

void Implicit::build(const Front& front, const ElementSet& elements, const TetMaterials& materials,
                     const PerVertex<std::uint8_t>& pinned) {
    matrix_.build(front, elements, pinned);
    preconditioner_.build(front, materials, pinned, matrix_);
    const std::size_t n = front.tree().vertex_count();
    for (PerVertex<Vec3>* field : {&base_x_, &base_v_, &trial_x_, &trial_v_, &inertia_, &nodal_, &point_diagonal_}) field->resize(n);
    fixed_.clear();
    for (VertexId v : front.vertices())
        if (front.state(v) == VertexState::free && pinned[v]) fixed_.push_back(v);
    for (DofVector* field : {&right_, &update_, &start_}) field->resize(matrix_.size());
}

void Implicit::set_base(const Front& front, const State& state, bool bdf2) {
    for (VertexId v : front.vertices()) {
        base_x_[v] = bdf2 ? Vec3((4 * state.x[v] - state.earlier_x[v]) / 3) : state.x[v];
        base_v_[v] = bdf2 ? Vec3((4 * state.v[v] - state.earlier_v[v]) / 3) : state.v[v];
        trial_v_[v] = state.v[v];
    }
}

/// Positions and the hanging vertices that belong to the trial velocity.
void Implicit::set_trial(const Problem& p) {
    for (VertexId v : fixed_) trial_v_[v].setZero();
    p.front.prolong(trial_v_);
    for (VertexId v : p.front.vertices()) trial_x_[v] = base_x_[v] + p.h * trial_v_[v];
}

/// Fills right_ with minus the residual of the trial state, and the tangent when asked to.
Implicit::Trial Implicit::evaluate(const Problem& p, bool tangent) {
    const double h = p.h;
    for (VertexId v : p.front.vertices()) inertia_[v] = (trial_v_[v] - base_v_[v]) - h * p.loads.gravity;
    p.elements.evaluate({.x = trial_x_,
                         .force_scale = h,
                         .inertia = &inertia_,
                         .velocity = &trial_v_,
                         .tangent = tangent,
                         .stiffness_scale = h * h,
                         .mass_scale = 1,
                         .damping_scale = h});
    p.elements.accumulate(nodal_);
    Trial trial;
    trial.scale = trial.potential = p.elements.potential();
    const auto add = [&](double energy) {
        trial.potential += energy;
        trial.scale += std::abs(energy);
    };
    const int nodes = p.front.nodes_per_tet();
    for (const PointForce& f : p.loads.forces) {
        add_at(f.at, nodes, h * f.force, nodal_);
        add(-h * f.force.dot(value_at(f.at, nodes, trial_v_)));
    }
    for (const PointSpring& s : p.loads.springs) {
        const Vec3 reach = s.target - value_at(s.at, nodes, trial_x_), velocity = value_at(s.at, nodes, trial_v_);
        add_at(s.at, nodes, h * (s.stiffness * reach - s.damping * velocity), nodal_);
        add(s.stiffness * reach.squaredNorm() / 2 + h * s.damping * velocity.squaredNorm() / 2);
    }
    for (const PointContact& c : p.loads.contacts) {
        const Vec3 x = value_at(c.at, nodes, trial_x_), v = value_at(c.at, nodes, trial_v_);
        add_at(c.at, nodes, h * c.force(x, v), nodal_);
        add(c.potential(x, v, h));
    }
    p.front.restrict_to_free(nodal_);
    const auto& vertex = matrix_.vertices();
    for (std::size_t i = 0; i < vertex.size(); ++i) right_[i] = nodal_[vertex[i]];
    trial.norm = std::sqrt(dot(right_, right_));
    return trial;
}

/// The incremental potential of standing still, v = 0 at x0. What lies below it has no more elastic energy than the
/// step had elastic and kinetic energy to start with. Needs `elements` as they were evaluated at x0.
double Implicit::standing_potential(const Problem& p, const State& state) {
    double sum = p.elements.energy();
    for (VertexId v : p.front.vertices()) inertia_[v] = base_v_[v] + p.h * p.loads.gravity;
    sum += p.elements.kinetic_energy(inertia_);
    for (const PointSpring& s : p.loads.springs)
        sum += s.stiffness * (s.target - value_at(s.at, p.front.nodes_per_tet(), state.x)).squaredNorm() / 2;
    for (const PointContact& c : p.loads.contacts) sum += c.potential(value_at(c.at, p.front.nodes_per_tet(), state.x), Vec3::Zero(), p.h);
    return sum;
}

/// The matrix of the trial state and its preconditioner.
void Implicit::assemble(const Problem& p) {
    const double h = p.h;
    const auto nodes = static_cast<std::size_t>(p.front.nodes_per_tet());
    matrix_.fill(p.elements);
    const bool points = !p.loads.springs.empty() || !p.loads.contacts.empty();
    if (points)
        for (VertexId v : p.front.vertices()) point_diagonal_[v].setZero();
    const auto add = [&](const Front::Point& at, const Mat3& block) {
        matrix_.add_point({at.nodes.data(), nodes}, {at.weights.data(), nodes}, block);
        add_at(at, p.front.nodes_per_tet(), block.diagonal(), point_diagonal_);
    };
    for (const PointSpring& s : p.loads.springs) add(s.at, (h * h * s.stiffness + h * s.damping) * Mat3::Identity());
    for (const PointContact& c : p.loads.contacts) {
        const int count = p.front.nodes_per_tet();
        const Mat3 block = c.tangent(value_at(c.at, count, trial_x_), value_at(c.at, count, trial_v_), h);
        if (!block.isZero(0)) add(c.at, block);
    }
    // Quadratic shape functions are negative in places; a diagonal is not.
    if (points)
        for (VertexId v : p.front.vertices()) point_diagonal_[v] = point_diagonal_[v].cwiseMax(0);
    preconditioner_.update(matrix_, {.stiffness_scale = h * h,
                                     .mass_scale = 1,
                                     .damping_scale = h,
                                     .x = trial_x_,
                                     .points = points ? &point_diagonal_ : nullptr,
                                     .contacts = !p.loads.contacts.empty()});
}

/// Newton's update for right_, a direction of descent. False: there is none.
bool Implicit::solve(const Problem& p, const ImplicitSettings& settings, const State& state, bool first, ImplicitReport& report) {
    const double guess = settings.rule == ImplicitRule::midpoint ? p.h : settings.time_step;
    const auto& vertex = matrix_.vertices();
    for (bool warm : {first, false}) {
        for (std::size_t i = 0; i < vertex.size(); ++i) update_[i] = warm ? Vec3(guess * state.a[vertex[i]]) : Vec3::Zero();
        const PcgResult solved = pcg_.solve(matrix_, preconditioner_, right_, update_, settings.pcg);
        report.solver_iterations += solved.iterations;
        report.residual = solved.residual;
        if (dot(right_, update_) > 0) {
            report.converged = report.converged && solved.converged;
            return true;
        }
        if (!warm) break;  // from zero even an unfinished solution descends, unless there is nothing to descend
    }
    return false;
}

/// Shortens update_ until the potential falls enough. A `linearised` update needs to be sound only, below the potential
/// of standing still; others get away with that at kinks of the energy (tets that are flat or inverted), where nothing
/// shorter helps, and then `stuck` is set. The tangent is evaluated as well, but after a linearised one.
/// False: no length does; the trial state is the one before.
bool Implicit::search(const Problem& p, bool linearised, Trial& trial, bool& stuck, ImplicitReport& report) {
    const double slope = -dot(right_, update_);  // < 0
    const auto& vertex = matrix_.vertices();
    for (std::size_t i = 0; i < vertex.size(); ++i) start_[i] = trial_v_[vertex[i]];
    const auto at = [&](double length) {
        for (std::size_t i = 0; i < vertex.size(); ++i) trial_v_[vertex[i]] = start_[i] + length * update_[i];
        set_trial(p);
        return evaluate(p, !linearised);
    };
    double length = 1, longest_sound = 0;
    for (int cut = 0; cut <= most_cuts; ++cut) {
        const Trial next = at(length);
        double shorter = 0.1;
        if (next.finite()) {
            const double change = next.potential - trial.potential;
            const double noise = potential_rounding * (trial.scale + next.scale);
            const bool falls = change <= least_decrease * length * slope + noise;
            const bool sound = next.potential <= ceiling_;
            if (falls || (linearised && sound) || std::abs(dot(right_, update_)) <= -enough_flattening * slope) {
                report.shortened += cut > 0;
                trial = next;
                return true;
            }
            if (sound && longest_sound == 0) longest_sound = length;
            if (longest_sound > 0 && length < shortest_before_stuck * longest_sound) break;
            shorter = std::clamp(-slope * length / (2 * (change - slope * length)), 0.1, 0.5);
        }
        length *= shorter;
    }
    ++report.shortened;
    stuck = longest_sound > 0;
    trial = at(longest_sound);
    return stuck;
}

/// What is left of a residual by the rounding of positions. Needs the matrix of the step.
double Implicit::rounding(double h) const {
    double sum = 0;
    const auto& vertex = matrix_.vertices();
    for (std::size_t i = 0; i < vertex.size(); ++i) {
        const double impulse = matrix_.diagonal_block(i).trace() / 3 * trial_x_[vertex[i]].norm() / h;
        sum += impulse * impulse;
    }
    return 4e-16 * std::sqrt(sum);
}

void Implicit::accept(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings,
                      ImplicitReport& report) {
    if (settings.rule == ImplicitRule::midpoint) {
        for (VertexId v : front.vertices()) {
            trial_v_[v] = 2 * trial_v_[v] - state.v[v];
            trial_x_[v] = 2 * trial_x_[v] - state.x[v];
        }
        elements.evaluate({.x = trial_x_});
    }
    report.finite = std::isfinite(elements.energy());
    for (VertexId v : front.vertices()) report.finite = report.finite && trial_x_[v].allFinite() && trial_v_[v].allFinite();
    if (!report.finite) return;
    for (VertexId v : front.vertices()) {
        state.a[v] = (trial_v_[v] - state.v[v]) / settings.time_step;
        state.earlier_x[v] = state.x[v];
        state.earlier_v[v] = state.v[v];
        state.x[v] = trial_x_[v];
        state.v[v] = trial_v_[v];
    }
    state.has_earlier = true;
}

ImplicitReport Implicit::failed(ImplicitReport report) {
    report.finite = report.converged = false;
    return report;
}

ImplicitReport Implicit::step(const Front& front, ElementSet& elements, State& state, const Loads& loads,
                              const ImplicitSettings& wanted) {
    ImplicitReport report;
    ImplicitSettings settings = wanted;
    // The midpoint's extrapolation would carry what has just been stopped at the ground on into it.
    if (settings.rule == ImplicitRule::midpoint && !loads.contacts.empty()) settings.rule = ImplicitRule::backward_euler;
    const bool bdf2 = settings.rule == ImplicitRule::bdf2 && state.has_earlier;
    const double part = settings.rule == ImplicitRule::midpoint ? 0.5 : bdf2 ? 2.0 / 3 : 1;
    const Problem p{front, elements, loads, part * settings.time_step};
    Stopwatch watch;
    set_base(front, state, bdf2);
    set_trial(p);
    ceiling_ = standing_potential(p, state);
    Trial trial = evaluate(p, true);
    // A linearised step does not see contact begin or end.
    const bool contact = std::ranges::any_of(loads.contacts, [&](const PointContact& c) {
        return c.pressing > 0 || c.depth(value_at(c.at, front.nodes_per_tet(), trial_x_)) > 0;
    });
    const bool rough = contact && settings.newton_iterations == 1;
    const double tolerance = rough ? rescue_tolerance : settings.newton_tolerance;
    if (rough) settings.pcg.tolerance = std::max(settings.pcg.tolerance, contact_forcing);
    int iterations = rough ? contact_iterations : settings.newton_iterations;
    const double first_norm = trial.norm;
    double floor = 0, goal = 0;
    for (int iteration = 0; trial.norm != 0; ++iteration) {
        if (!trial.finite()) return failed(report);
        const bool sound = !rough || trial.potential <= ceiling_;
        if (iteration > 0 && trial.norm <= goal && sound) break;
        if (iteration >= iterations) {
            if (!sound && iterations < rescue_iterations) {
                iterations = rescue_iterations;
                continue;
            }
            report.converged = report.converged && rough && sound;
            break;
        }
        assemble(p);
        report.assemble_milliseconds += watch.lap();
        if (iteration == 0) {
            floor = rounding(p.h);
            goal = std::max(tolerance * first_norm, floor);
            if (trial.norm <= floor) break;
        }
        const bool found = solve(p, settings, state, iteration == 0, report);
        report.solve_milliseconds += watch.lap();
        ++report.newton_iterations;
        const bool linearised = iterations == 1;
        const int cuts = report.shortened;
        bool stuck = false;
        if (!found || !search(p, linearised, trial, stuck, report)) {
            if (iteration == 0) return failed(report);
            report.converged = false;
            break;
        }
        if (stuck) {
            report.converged = false;
            break;
        }
        if (!linearised) continue;
        if (report.shortened == cuts) break;
        report.rescued = true;
        iterations = rescue_iterations;
        goal = std::max(rescue_tolerance * first_norm, floor);
        trial = evaluate(p, true);
    }
    accept(front, elements, state, settings, report);
    report.converged = report.converged && report.finite;
    report.assemble_milliseconds += watch.lap();
    return report;
}

}  // namespace tetfront
