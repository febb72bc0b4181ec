// What a step does: timeline, adapt, advance, measure.
#include <algorithm>
#include <iterator>

#include "engine/mechanics/rigid_motion.hpp"
#include "engine/simulation/simulation_impl.hpp"

namespace tetfront {

namespace {
ImplicitRule rule_of(Scheme scheme) {
    if (scheme == Scheme::midpoint) return ImplicitRule::midpoint;
    if (scheme == Scheme::bdf2) return ImplicitRule::bdf2;
    return ImplicitRule::backward_euler;
}
Integrator integrator_of(Scheme scheme) {
    if (scheme == Scheme::explicit_euler) return Integrator::explicit_euler;
    if (scheme == Scheme::automatic) return Integrator::automatic;
    return Integrator::implicit;
}
/// A front that has not come to rest after so many rounds of settling is left as it is.
constexpr int most_settling_rounds = 20;
}  // namespace

Simulation::Impl::Impl(std::shared_ptr<const Model> m, const FrontSpec& spec)
    : model(std::move(m)),
      front_spec(spec),
      front(model->tree, spec.order, spec.min_level, spec.max_level),
      pins(*model),
      adaptivity(model->matrices, pins.unresolved),
      frames(model->frame_model, model->surface, model->matrices) {
    const Scene& scene = model->scene;
    gravity = scene.gravity;
    adapt_settings.tolerance = spec.tolerance;
    budget_tets = static_cast<std::size_t>(spec.budget_tets);
    budget_milliseconds = spec.budget_milliseconds;
    for (TetId t : model->tree.level(0)) adapt_settings.energy_floor += 1e-8 * model->tree.volume(t) * model->matrices.elasticity[t](0, 0);
    settings.time_step = scene.time_step;
    settings.rule = rule_of(scene.solver.scheme);
    integrator = integrator_of(scene.solver.scheme);
    settings.newton_iterations = scene.solver.newton_iterations;
    settings.newton_tolerance = scene.solver.newton_tolerance;
    settings.pcg = {scene.solver.cg_tolerance, scene.solver.cg_iterations};
    elements.set_strain_measure(scene.solver.strain);
    state.resize(model->tree.vertex_count());
    start();
}

void Simulation::Impl::start() {
    for (VertexId v : front.vertices()) state.rest_at(v, model->tree.rest(v));
    state.has_earlier = false;
    time = 0;
    steps = 0;
    report = {};
    adaptivity.clear();
    for (const TimelineEvent& event : model->scene.timeline) {
        if (event.gravity) gravity = model->scene.gravity;
        if (event.release) pins.hold(*model, edits.pins, steps, settings.time_step);
    }
    resolve_pins();
    rebuild();
    measure_anew();
    if (model->scene.solver.start == Start::equilibrium) settle();
}

void Simulation::Impl::measure_anew() {
    elements.evaluate({.x = state.x});
    adaptivity.measure(front, elements, state.x, 0, 0, adapt_settings);
    describe(report);
}

StepReport Simulation::Impl::settle() {
    StepReport r;
    lap();
    bool rested = false;
    for (int round = 0; round < most_settling_rounds && !rested; ++round) {
        const Advance a = stepper.settle(front, elements, state, settings, model->size, [this](Loads& loads, double h) { add_loads(loads, h); });
        describe(a, r);
        adaptivity.clear();  // energies of another shape
        adaptivity.measure(front, elements, state.x, 0, 0, adapt_settings);
        r.milliseconds.other += lap();
        if (!a.done) break;
        adapt(r);
        rested = r.splits + r.merges == 0;
    }
    r.converged = r.converged && rested;
    describe(r);
    if (!r.converged) r.warning = "no equilibrium was found: what is not held has none, or the front went on changing";
    report = r;
    return r;
}

/// What an advance did, added to a report.
void Simulation::Impl::describe(const Advance& a, StepReport& r) {
    r.rejected = !a.done;
    r.converged = a.done && a.converged;
    r.newton_iterations += a.newton_iterations;
    r.solver_iterations += a.solver_iterations;
    r.substeps = a.substeps;
    r.residual = a.residual;
    r.milliseconds.assemble += a.assemble_milliseconds;
    r.milliseconds.solve += a.solve_milliseconds;
}

void Simulation::Impl::place(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) {
    for (VertexId i : front.vertices()) {
        state.rest_at(i, x[i]);
        state.v[i] = v[i];
    }
    state.has_earlier = false;
    transfer({});
    elements.evaluate({.x = state.x});
    adaptivity.measure(front, elements, state.x, 0, 0, adapt_settings);
    describe(report);
}

void Simulation::Impl::resolve_pins() {
    for (bool changed = true; changed;) {
        changed = false;
        const std::vector<TetId> active = front.active();
        for (TetId t : active)
            if (pins.unresolved[t] && front.split(t)) changed = true;
        transfer(front.commit());
    }
}

void Simulation::Impl::rebuild() {
    const TetMaterials materials{matrices().elasticity, model->density, matrices().mass_damping, matrices().stiffness_damping};
    elements.build(front, materials);
    stepper.build(front, elements, materials, pins.pinned, integrator);
}

void Simulation::Impl::apply_timeline() {
    bool released = false;
    for (const TimelineEvent& event : model->scene.timeline) {
        if (step_of(event, settings.time_step) != steps) continue;
        if (event.gravity) gravity = *event.gravity;
        released = released || event.release;
    }
    if (!released) return;
    pins.hold(*model, edits.pins, steps, settings.time_step);
    rebuild();
    elements.evaluate({.x = state.x});  // what steps begin with
}

void Simulation::Impl::transfer(const Front::Change& change) {
    // Rows point to older vertices, so one ascending pass over both kinds sees final values only.
    std::vector<VertexId> dependent;
    std::ranges::set_union(change.appeared, front.hanging(), std::back_inserter(dependent));
    for (VertexId v : dependent) {
        if (model->tree.row(front.order(), v).vertices.empty()) continue;
        for (PerVertex<Vec3>* field : {&state.x, &state.v, &state.a, &state.earlier_x, &state.earlier_v})
            (*field)[v] = front.interpolate(*field, v);
    }
    for (VertexId v : front.vertices())
        if (pins.pinned[v]) state.rest_at(v, pins.pinned[v] == Pins::at_rest ? model->tree.rest(v) : state.x[v]);
}

void Simulation::Impl::apply_budget() {
    std::size_t most = budget_tets;
    if (budget_milliseconds > 0 && milliseconds_per_tet > 0)
        most = std::min(most, static_cast<std::size_t>(budget_milliseconds / milliseconds_per_tet));
    adapt_settings.most_tets = std::max<std::size_t>(1, most);
}

void Simulation::Impl::adapt(StepReport& r) {
    apply_budget();
    const auto changes = adaptivity.adapt(front, steps, adapt_settings);
    r.splits = changes[0];
    r.merges = changes[1];
    const bool any = changes[0] + changes[1] > 0, free_body = any && !pins.any;
    const auto momentum = [&](const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) {
        return free_body ? elements.momentum(x, v) : Momentum{};
    };
    const Momentum before = momentum(state.x, state.v);
    const Momentum earlier = momentum(state.earlier_x, state.earlier_v);
    const double energy_before = any ? total_energy() : 0;
    const Front::Change& change = front.commit();
    r.milliseconds.adapt += lap();
    if (!change.any()) return;
    adaptivity.rest(change.activated, steps, adapt_settings);
    transfer(change);
    rebuild();
    if (free_body) {
        restore_momentum(before, front.vertices(), elements, model->size, state.x, state.v, scratch_);
        if (state.has_earlier)
            restore_momentum(earlier, front.vertices(), elements, model->size, state.earlier_x, state.earlier_v, scratch_);
    }
    elements.evaluate({.x = state.x});
    r.energy_change = total_energy() - energy_before;
    r.milliseconds.setup += lap();
}

double Simulation::Impl::total_energy() const {
    return elements.energy() + elements.kinetic_energy(state.v) - gravity.dot(elements.first_moment(state.x));
}

void Simulation::Impl::add_loads(Loads& loads, double time_step) const {
    loads.gravity = gravity;
    for (const AttachedForce& f : model->forces)
        if (time >= f.start && time < f.end) loads.forces.push_back({front.locate(f.at.leaf, f.at.barycentric), f.force});
    for (const PointLoad& f : edit_forces) loads.forces.push_back({front.locate(f.at.leaf, f.at.barycentric), f.force});
    pulls.add_to(loads, front, *model, state.x);
    if (model->ground) model->ground->add_contacts(loads, front, matrices(), state, time_step);
}

std::vector<FrameForce> Simulation::Impl::seen_forces() const {
    std::vector<FrameForce> seen;
    const auto add = [&](const Vec3& at, const Vec3& value) {
        FrameForce& force = seen.emplace_back();
        for (int c = 0; c < 3; ++c) {
            force.at[static_cast<std::size_t>(c)] = static_cast<float>(at[c]);
            force.value[static_cast<std::size_t>(c)] = static_cast<float>(value[c]);
        }
    };
    const auto place = [&](const Attachment& at) {
        return value_at(front.locate(at.leaf, at.barycentric), front.nodes_per_tet(), state.x);
    };
    // The points of a region follow each other.
    for (auto first = model->forces.begin(); first != model->forces.end();) {
        const auto last = std::find_if(first, model->forces.end(), [&](const AttachedForce& f) { return f.spec != first->spec; });
        if (time >= first->start && time < first->end) {
            Vec3 middle = Vec3::Zero(), total = Vec3::Zero();
            for (auto f = first; f != last; ++f) middle += place(f->at), total += f->force;
            add(middle / static_cast<double>(last - first), total);
        }
        first = last;
    }
    for (const PointLoad& f : edit_forces) add(place(f.at), f.force);
    return seen;
}

void Simulation::Impl::describe(StepReport& r) const {
    r.step = steps;
    r.time = time;
    r.estimate = adaptivity.estimate();
    r.inverted_tets = elements.inverted();
    r.tets_by_level.assign(static_cast<std::size_t>(model->tree.depth()) + 1, 0);
    for (TetId t : front.active()) ++r.tets_by_level[static_cast<std::size_t>(model->tree.level_of(t))];
    r.free_vertices = static_cast<std::uint32_t>(front.free_count());
    r.hanging_vertices = static_cast<std::uint32_t>(front.hanging().size());
}

double Simulation::Impl::lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - phase_start_).count();
    phase_start_ = now;
    return ms;
}

StepReport Simulation::Impl::step() {
    StepReport r;
    lap();
    apply_timeline();
    adapt(r);
    const Advance a = stepper.advance(front, elements, state, settings, model->size, [this](Loads& loads, double h) { add_loads(loads, h); });
    lap();
    ++steps;
    describe(a, r);
    if (r.rejected) {
        r.warning = a.too_stiff ? "explicit steps would need more than 20000 substeps; the object stands still: use an implicit scheme"
                                : "the step failed even when cut in 16; the object stands still: reset, or reduce forces or the time step";
        for (VertexId v : front.vertices()) state.rest_at(v, state.x[v]);
    } else {
        time = static_cast<double>(steps) * settings.time_step;
        if (a.parts > 1) r.warning = "the time step was cut in " + std::to_string(a.parts) + " to stay stable";
    }
    const double kinetic = pins.firm ? elements.kinetic_energy(state.v) : 0;
    adaptivity.measure(front, elements, state.x, settings.time_step, kinetic, adapt_settings);
    r.milliseconds.adapt += lap();
    describe(r);
    if (r.warning.empty() && !r.converged) r.warning = "the solver stopped before its tolerance: motion may be wrong";
    r.milliseconds.other += lap();
    milliseconds_per_tet = std::max(0.98 * milliseconds_per_tet, r.milliseconds.total() / static_cast<double>(front.active().size()));
    report = r;
    return r;
}

}  // namespace tetfront
