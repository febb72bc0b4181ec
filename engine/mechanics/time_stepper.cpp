#include "engine/mechanics/time_stepper.hpp"

namespace tetfront {

namespace {
/// In units of the object's size: what no vertex does relative to the others in one step, however it spins.
constexpr double farthest_motion = 4;
constexpr int most_parts = 16;
}  // namespace

void TimeStepper::build(const Front& front, const ElementSet& elements, const TetMaterials& materials,
                        const PerVertex<std::uint8_t>& pinned) {
    implicit_.build(front, elements, materials, pinned);
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

Advance TimeStepper::advance(const Front& front, ElementSet& elements, State& state, const ImplicitSettings& settings,
                             double size, const std::function<void(Loads&)>& loads) {
    save(front, state);
    Advance a;
    for (a.parts = 1; a.parts <= most_parts; a.parts *= 2) {
        ImplicitSettings s = settings;
        s.time_step /= a.parts;
        bool sound = true;
        a.converged = true;
        if (a.parts > 1) state.has_earlier = false;  // one whole step earlier, not one part
        for (int part = 0; part < a.parts && sound; ++part) {
            loads_.forces.clear();
            loads_.springs.clear();
            loads(loads_);
            const ImplicitReport one = implicit_.step(front, elements, state, loads_, s);
            sound = one.finite && !torn_apart(front, state, size);
            a.converged = a.converged && one.converged;
            a.rescued = a.rescued || one.rescued;
            a.newton_iterations += one.newton_iterations;
            a.solver_iterations += one.solver_iterations;
            a.residual = one.residual;
            a.assemble_milliseconds += one.assemble_milliseconds;
            a.solve_milliseconds += one.solve_milliseconds;
        }
        if (sound) {
            if (a.parts > 1) state.has_earlier = false;
            return a;
        }
        undo(front, state);
    }
    state.has_earlier = false;
    elements.evaluate({.x = state.x});
    a.done = false;
    return a;
}

}  // namespace tetfront
