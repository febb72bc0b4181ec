#include "engine/mechanics/time_stepper.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace tetfront {

namespace {
/// In units of the object's size: what no vertex does relative to the others in one step, however it spins.
constexpr double farthest_motion = 4;
constexpr int most_parts = 16;
/// The other integrator must be cheaper by this to be changed to; one that is not more than `close` times as dear is tried
/// again every so many steps, as its cost may have changed.
constexpr double hysteresis = 0.9, close = 4;
constexpr int try_again = 120;
/// Equilibrium: the kinetic energy of the last, long step over the elastic energy, and how far it went; steps until it is given up.
constexpr double still = 1e-10;
constexpr double least_motion = 1e-6;  // of the object's size
constexpr double most_motion = 100;    // in one step, when nothing holds it
constexpr int most_settling_steps = 200;

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}
}  // namespace

void TimeStepper::build(const Front& front, const ElementSet& elements, const TetMaterials& materials,
                        const PerVertex<std::uint8_t>& pinned, Integrator integrator) {
    integrator_ = integrator;
    built_for_.emplace(BuiltFor{front, elements, materials, pinned});
    implicit_built_ = explicit_built_ = false;
}

Implicit& TimeStepper::built_implicit() {
    if (!std::exchange(implicit_built_, true))
        implicit_.build(built_for_->front, built_for_->elements, built_for_->materials, built_for_->pinned);
    return implicit_;
}

Explicit& TimeStepper::built_explicit() {
    if (!std::exchange(explicit_built_, true)) explicit_.build(built_for_->front, built_for_->materials, built_for_->pinned);
    return explicit_;
}

void TimeStepper::save(const Front& front, const State& state) {
    saved_.clear();
    for (VertexId v : front.vertices()) saved_.push_back({state.x[v], state.v[v], state.a[v], state.earlier_x[v], state.earlier_v[v]});
    had_earlier_ = state.has_earlier;
}

void TimeStepper::undo(const Front& front, State& state) const {
    for (std::size_t i = 0; i < saved_.size(); ++i) {
        const VertexId v = front.vertices()[i];
        state.x[v] = saved_[i].x;
        state.v[v] = saved_[i].v;
        state.a[v] = saved_[i].a;
        state.earlier_x[v] = saved_[i].earlier_x;
        state.earlier_v[v] = saved_[i].earlier_v;
    }
    state.has_earlier = had_earlier_;
}

/// Some vertex has left the others behind by several times the object's size since the step began: linearised steps
/// on extreme stiffness contrasts can grow without bound long before they overflow.
bool TimeStepper::torn_apart(const Front& front, const State& state, double size) const {
    const std::vector<VertexId>& vertices = front.vertices();
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = 0; i < saved_.size(); ++i) mean += (state.x[vertices[i]] - saved_[i].x) / static_cast<double>(saved_.size());
    for (std::size_t i = 0; i < saved_.size(); ++i)
        if (!((state.x[vertices[i]] - saved_[i].x - mean).norm() < farthest_motion * size)) return true;
    return false;
}

void TimeStepper::collect(const LoadsOfStep& loads, double time_step) {
    loads_.forces.clear();
    loads_.springs.clear();
    loads_.contacts.clear();
    loads(loads_, time_step);
}

bool TimeStepper::prefers_explicit(double time_step) {
    const double substeps = built_explicit().substeps(time_step);
    if (implicit_cost_ == 0 || substep_cost_ == 0 || substeps > most_substeps) return false;
    const double ratio = substeps * substep_cost_ / implicit_cost_;
    const bool cheaper = last_explicit_ ? ratio * hysteresis < 1 : ratio < hysteresis;
    const bool again = untried_ >= try_again && ratio < close && ratio > 1 / close;
    return cheaper != again;
}

bool TimeStepper::explicit_part(const Front& front, ElementSet& elements, State& state, double time_step, int parts, Advance& a) {
    Explicit& integrator = built_explicit();
    const auto start = std::chrono::steady_clock::now();
    // Parts that failed at the stable substep take shorter ones.
    const ExplicitReport one = integrator.step(front, elements, state, loads_, time_step, parts);
    const double ms = milliseconds_since(start);
    a.substeps += one.substeps;
    a.assemble_milliseconds += ms;
    const double cost = ms / one.substeps / static_cast<double>(elements.size());
    substep_cost_ = substep_cost_ == 0 ? cost : 0.8 * substep_cost_ + 0.2 * cost;
    return one.finite;
}

bool TimeStepper::implicit_part(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, Advance& a) {
    const ImplicitReport one = built_implicit().step(front, elements, state, loads_, settings);
    a.converged = a.converged && one.converged;
    a.rescued = a.rescued || one.rescued;
    a.newton_iterations += one.newton_iterations;
    a.solver_iterations += one.solver_iterations;
    a.residual = one.residual;
    a.assemble_milliseconds += one.assemble_milliseconds;
    a.solve_milliseconds += one.solve_milliseconds;
    const double cost = (one.assemble_milliseconds + one.solve_milliseconds) / static_cast<double>(elements.size());
    implicit_cost_ = implicit_cost_ == 0 ? cost : 0.8 * implicit_cost_ + 0.2 * cost;
    return one.finite;
}

Advance TimeStepper::advance(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings,
                             double size, const LoadsOfStep& loads) {
    bool explicitly = integrator_ == Integrator::explicit_euler;
    if (integrator_ == Integrator::automatic) {
        if (substep_cost_ == 0) {
            const auto start = std::chrono::steady_clock::now();
            elements.evaluate({.x = state.x, .velocity = &state.v});
            substep_cost_ = milliseconds_since(start) / static_cast<double>(elements.size());
        }
        explicitly = prefers_explicit(settings.time_step);
        untried_ = explicitly == last_explicit_ ? untried_ + 1 : 0;
        last_explicit_ = explicitly;
    }
    save(front, state);
    Advance a;
    for (a.parts = 1; a.parts <= most_parts; a.parts *= 2) {
        if (explicitly && built_explicit().substeps(settings.time_step * a.parts) > most_substeps) {
            a.too_stiff = true;
            break;
        }
        ImplicitSettings s = settings;
        s.time_step /= a.parts;
        bool sound = true;
        a.converged = true;
        if (a.parts > 1) state.has_earlier = false;  // one whole step earlier, not one part
        for (int part = 0; part < a.parts && sound; ++part) {
            collect(loads, s.time_step);
            sound = explicitly ? explicit_part(front, elements, state, s.time_step, a.parts, a) : implicit_part(front, elements, state, s, a);
            sound = sound && !torn_apart(front, state, size);
        }
        if (sound) {
            if (a.parts > 1) state.has_earlier = false;
            return a;
        }
        undo(front, state);
        elements.evaluate({.x = state.x});  // what a step begins with
    }
    state.has_earlier = false;
    a.done = false;
    return a;
}

Advance TimeStepper::settle(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings, double size,
                            const LoadsOfStep& loads) {
    Advance a;
    ImplicitSettings s = settings;
    s.rule = ImplicitRule::backward_euler;
    s.newton_iterations = 20;
    s.newton_tolerance = 1e-3;
    a.done = false;
    for (int n = 0; n < most_settling_steps && !a.done; ++n) {
        for (VertexId v : front.vertices()) {
            state.v[v].setZero();
            state.a[v].setZero();
        }
        save(front, state);
        collect(loads, s.time_step);
        a.converged = true;
        if (!implicit_part(front, elements, state, s, a) || torn_apart(front, state, size)) {
            undo(front, state);
            elements.evaluate({.x = state.x});
            s.time_step /= 4;
            continue;
        }
        double moved = 0;
        for (std::size_t i = 0; i < saved_.size(); ++i) moved = std::max(moved, (state.x[front.vertices()[i]] - saved_[i].x).norm());
        if (moved > most_motion * size) break;
        const bool at_rest = elements.kinetic_energy(state.v) <= still * elements.energy() || moved <= 1e-12 * size;
        a.done = at_rest && moved <= least_motion * size && (a.converged || moved <= 1e-12 * size);
        s.time_step *= 2;
    }
    a.converged = a.done;
    for (VertexId v : front.vertices()) state.rest_at(v, state.x[v]);
    state.has_earlier = false;
    return a;
}

}  // namespace tetfront
