#include "engine/simulation/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/mechanics/adaptivity.hpp"
#include "engine/mechanics/element.hpp"
#include "engine/mechanics/implicit.hpp"
#include "engine/mechanics/rigid_motion.hpp"
#include "engine/simulation/frame_builder.hpp"
#include "engine/simulation/surface_field.hpp"

namespace tetfront {

namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// A pull is a critically damped spring that acts as if never longer than this part of the object's size ...
constexpr double pull_reach = 0.5;
/// ... and then accelerates the object as a whole with this [m/s^2], whatever its size and mass.
constexpr double pull_acceleration = 50;
/// In units of the object's size: what no vertex does relative to the others in one step, however it spins.
constexpr double farthest_motion = 4;

}  // namespace

struct Simulation::Impl {
    struct Pull {
        Attachment at;
        Vec3 target;
    };

    Impl(std::shared_ptr<const Model> m, const FrontSpec& spec)
        : model(std::move(m)),
          front(model->tree, spec.order, spec.min_level, spec.max_level),
          adaptivity(model->matrices, model->unresolved),
          frames(model->frame_model, model->surface),
          pinned(model->pinned),
          has_pins(model->has_pins) {
        const Scene& scene = model->scene;
        gravity = scene.gravity;
        adapt_settings.tolerance = spec.tolerance;
        budget_tets = static_cast<std::size_t>(spec.budget_tets);
        budget_milliseconds = spec.budget_milliseconds;
        for (TetId t : model->tree.level(0)) adapt_settings.energy_floor += 1e-8 * model->tree.volume(t) * model->matrices.elasticity[t](0, 0);
        settings.time_step = scene.time_step;
        settings.midpoint = scene.solver.scheme == Scheme::midpoint;
        settings.newton_iterations = scene.solver.newton_iterations;
        settings.newton_tolerance = scene.solver.newton_tolerance;
        settings.pcg = {scene.solver.cg_tolerance, scene.solver.cg_iterations};
        state.x.resize(model->tree.vertex_count());
        state.v.resize(model->tree.vertex_count());
        state.a.resize(model->tree.vertex_count());
        start();
    }

    /// State at rest on the front as it is.
    void start() {
        for (VertexId v : front.vertices()) {
            state.x[v] = model->tree.rest(v);
            state.v[v].setZero();
            state.a[v].setZero();
        }
        time = 0;
        steps = 0;
        report = {};
        adaptivity.clear();
        for (const TimelineEvent& event : model->scene.timeline) {
            if (event.gravity) gravity = model->scene.gravity;
            if (event.release) hold_pins();
        }
        resolve_pins();
        rebuild();
        elements.evaluate({.x = state.x});
        adaptivity.measure(front, elements, state.x, 0, 0, adapt_settings);
        describe(report);
    }

    /// Splits tets that miss a pinned region, until none does.
    void resolve_pins() {
        for (bool changed = true; changed;) {
            changed = false;
            const std::vector<TetId> active = front.active();
            for (TetId t : active)
                if (model->unresolved[t] && front.split(t)) changed = true;
            transfer(front.commit());
        }
    }

    void rebuild() {
        const TetMaterials materials{model->matrices.elasticity, model->density, model->matrices.mass_damping,
                                     model->matrices.stiffness_damping};
        elements.build(front, materials);
        implicit.build(front, elements, materials, pinned);
    }

    /// The step before which an event of the timeline takes place: the one whose start is nearest.
    [[nodiscard]] std::uint64_t step_of(const TimelineEvent& event) const {
        return static_cast<std::uint64_t>(std::llround(event.time / settings.time_step));
    }

    /// Pins every vertex of the pins that are not released by now. It follows from `steps` alone.
    void hold_pins() {
        std::vector<Region> held;
        for (std::size_t i = 0; i < model->scene.pins.size(); ++i) {
            const auto released = [&](const TimelineEvent& e) {
                return e.release && static_cast<std::size_t>(*e.release) == i && step_of(e) <= steps;
            };
            if (std::ranges::none_of(model->scene.timeline, released)) held.push_back(model->scene.pins[i]);
        }
        has_pins = false;
        for (VertexId v : ids<VertexId>(pinned.size())) {
            if (!model->pinned[v]) continue;
            pinned[v] = std::ranges::any_of(held, [&](const Region& r) { return contains(r, model->tree.rest(v)); });
            has_pins = has_pins || pinned[v];
        }
    }

    /// What the scene's timeline has for the step that begins. Cost: the timeline; the tree only when a pin is released.
    void apply_timeline() {
        bool released = false;
        for (const TimelineEvent& event : model->scene.timeline) {
            if (step_of(event) != steps) continue;
            if (event.gravity) gravity = *event.gravity;
            released = released || event.release;
        }
        if (!released) return;
        hold_pins();
        rebuild();
    }

    /// Gives vertices that appeared their place and velocity, and hanging ones theirs.
    void transfer(const Front::Change& change) {
        // Rows point to older vertices, so one ascending pass over both kinds sees final values only.
        std::vector<VertexId> dependent;
        std::ranges::set_union(change.appeared, front.hanging(), std::back_inserter(dependent));
        for (VertexId v : dependent) {
            if (model->tree.row(front.order(), v).vertices.empty()) continue;
            state.x[v] = front.interpolate(state.x, v);
            state.v[v] = front.interpolate(state.v, v);
            state.a[v] = front.interpolate(state.a, v);
        }
        for (VertexId v : front.vertices()) {
            if (!pinned[v]) continue;
            state.x[v] = model->tree.rest(v);
            state.v[v].setZero();
            state.a[v].setZero();
        }
    }

    /// Turns the budget into a number of tets. A budget of time uses what tets have cost at most lately, changes of the
    /// front included.
    void apply_budget() {
        std::size_t most = budget_tets;
        if (budget_milliseconds > 0 && milliseconds_per_tet > 0)
            most = std::min(most, static_cast<std::size_t>(budget_milliseconds / milliseconds_per_tet));
        adapt_settings.most_tets = std::max<std::size_t>(1, most);
    }

    void adapt(StepReport& r) {
        apply_budget();
        const auto changes = adaptivity.adapt(front, steps, adapt_settings);
        r.splits = changes[0];
        r.merges = changes[1];
        const bool any = changes[0] + changes[1] > 0, free_body = any && !has_pins;
        const ElementSet::Momentum before = free_body ? elements.momentum(state.x, state.v) : ElementSet::Momentum{};
        const double energy_before = any ? total_energy() : 0;
        const Front::Change& change = front.commit();
        r.milliseconds.adapt += lap();
        if (!change.any()) return;
        adaptivity.rest(change.activated, steps, adapt_settings);
        transfer(change);
        rebuild();
        if (free_body) restore_momentum(before, front.vertices(), elements, model->size, state.x, state.v, scratch);
        elements.evaluate({.x = state.x});
        r.energy_change = total_energy() - energy_before;
        r.milliseconds.setup += lap();
    }

    /// Of the last evaluation of `elements` [J]: elastic, kinetic, and in the gravity field up to a constant.
    [[nodiscard]] double total_energy() const {
        return elements.energy() + elements.kinetic_energy(state.v) - gravity.dot(elements.first_moment(state.x));
    }

    Loads loads() const {
        Loads l;
        l.gravity = gravity;
        for (const AttachedForce& f : model->forces) {
            if (time >= f.start && time < f.end) l.forces.push_back({front.locate(f.at.leaf, f.at.barycentric), f.force});
        }
        for (const auto& [id, pull] : pulls) {
            PointSpring spring{front.locate(pull.at.leaf, pull.at.barycentric), pull.target, 0, 0};
            const Vec3 from = position(spring.at), reach = pull.target - from;
            const double longest = pull_reach * model->size;
            spring.stiffness = model->mass * pull_acceleration / longest;
            spring.damping = 2 * std::sqrt(spring.stiffness * model->mass);
            if (reach.norm() > longest) spring.target = from + reach * (longest / reach.norm());
            l.springs.push_back(spring);
        }
        return l;
    }

    [[nodiscard]] Vec3 position(const Front::Point& p) const {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < static_cast<std::size_t>(front.nodes_per_tet()); ++i) sum += p.weights[i] * state.x[p.nodes[i]];
        return sum;
    }

    /// Some vertex has left the others behind by several times the object's size since the step began: linearised steps
    /// on extreme stiffness contrasts can grow without bound long before they overflow.
    [[nodiscard]] bool torn_apart() const {
        const std::vector<VertexId>& vertices = front.vertices();
        Vec3 mean = Vec3::Zero();
        for (std::size_t i = 0; i < saved.size(); ++i) mean += (state.x[vertices[i]] - saved[i][0]) / static_cast<double>(saved.size());
        for (std::size_t i = 0; i < saved.size(); ++i)
            if (!((state.x[vertices[i]] - saved[i][0] - mean).norm() < farthest_motion * model->size)) return true;
        return false;
    }

    /// Advances by one time step, in smaller ones when it fails. False: the state is as before.
    bool advance(StepReport& r) {
        saved.clear();
        for (VertexId v : front.vertices()) saved.push_back({state.x[v], state.v[v], state.a[v]});
        for (int parts = 1; parts <= 16; parts *= 2) {
            ImplicitSettings s = settings;
            s.time_step /= parts;
            bool finite = true;
            r.converged = true;
            for (int part = 0; part < parts && finite; ++part) {
                const ImplicitReport one = implicit.step(front, elements, state, loads(), s);
                finite = one.finite && !torn_apart();
                r.converged = r.converged && one.converged;
                r.newton_iterations += one.newton_iterations;
                r.solver_iterations += one.solver_iterations;
                r.residual = one.residual;
                r.milliseconds.assemble += one.assemble_milliseconds;
                r.milliseconds.solve += one.solve_milliseconds;
            }
            if (finite) {
                if (parts > 1) r.warning = "the time step was cut in " + std::to_string(parts) + " to stay stable";
                return true;
            }
            for (std::size_t i = 0; i < saved.size(); ++i) {
                state.x[front.vertices()[i]] = saved[i][0];
                state.v[front.vertices()[i]] = saved[i][1];
                state.a[front.vertices()[i]] = saved[i][2];
            }
        }
        elements.evaluate({.x = state.x});
        return false;
    }

    /// The parts of a report that describe the present state.
    void describe(StepReport& r) const {
        r.step = steps;
        r.time = time;
        r.estimate = adaptivity.estimate();
        r.inverted_tets = elements.inverted();
        r.tets_by_level.assign(static_cast<std::size_t>(model->tree.depth()) + 1, 0);
        for (TetId t : front.active()) ++r.tets_by_level[static_cast<std::size_t>(model->tree.level_of(t))];
        r.free_vertices = static_cast<std::uint32_t>(front.free_count());
        r.hanging_vertices = static_cast<std::uint32_t>(front.hanging().size());
    }

    double lap() {
        const double ms = milliseconds_since(phase_start);
        phase_start = std::chrono::steady_clock::now();
        return ms;
    }

    StepReport step() {
        StepReport r;
        phase_start = std::chrono::steady_clock::now();
        apply_timeline();
        adapt(r);
        r.rejected = !advance(r);
        lap();
        ++steps;
        if (r.rejected) {
            r.converged = false;
            r.warning = "the step failed even when cut in 16; the object stands still: reset, or reduce forces or the time step";
            for (VertexId v : front.vertices()) {
                state.v[v].setZero();
                state.a[v].setZero();
            }
        } else {
            time = static_cast<double>(steps) * settings.time_step;
        }
        const double kinetic = model->held ? elements.kinetic_energy(state.v) : 0;
        adaptivity.measure(front, elements, state.x, settings.time_step, kinetic, adapt_settings);
        r.milliseconds.adapt += lap();
        describe(r);
        if (r.warning.empty() && !r.converged) r.warning = "the solver stopped before its tolerance: motion may be wrong";
        r.milliseconds.other += lap();
        milliseconds_per_tet = std::max(0.98 * milliseconds_per_tet, r.milliseconds.total() / static_cast<double>(front.active().size()));
        report = r;
        return r;
    }

    void begin_pull(std::uint64_t id, const SurfacePoint& point, const Vec3& target) {
        const auto& triangles = model->surface.mesh.triangles;
        if (point.triangle >= triangles.size()) {
            throw InputError("", "/triangle", "is " + std::to_string(point.triangle), "use 0.." + std::to_string(triangles.size() - 1));
        }
        const Vec3& b = point.barycentric;
        if (!b.allFinite() || b.minCoeff() < -1e-9 || std::abs(b.sum() - 1) > 1e-3)
            throw InputError("", "/barycentric", "is not a point of the triangle", "use three numbers >= 0 with sum 1");
        check_target(target);
        // The point takes the leaf of its nearest corner: at most about one leaf away from it.
        const auto& triangle = triangles[point.triangle];
        Vec3 rest = Vec3::Zero();
        int nearest = 0;
        for (int i = 0; i < 3; ++i) {
            rest += b[i] * model->surface.mesh.positions[static_cast<std::size_t>(triangle[static_cast<std::size_t>(i)])];
            if (b[i] > b[nearest]) nearest = i;
        }
        const TetId leaf = model->surface.attachment[static_cast<std::size_t>(triangle[static_cast<std::size_t>(nearest)])].leaf;
        const auto& c = model->tree.corners(leaf);
        const TetTree& tree = model->tree;
        const auto g = barycentric_gradients({tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3])});
        Attachment at{leaf, Vec4::Zero()};
        const Vec3 d = rest - tree.rest(c[0]);
        for (int k = 0; k < 3; ++k) at.barycentric[k + 1] = g(k, 0) * d[0] + g(k, 1) * d[1] + g(k, 2) * d[2];
        at.barycentric[0] = 1 - at.barycentric.tail<3>().sum();
        pulls[id] = {at, target};
    }

    static void check_target(const Vec3& target) {
        if (!target.allFinite() || target.cwiseAbs().maxCoeff() > 1e9)
            throw InputError("", "/target", "is not a position", "use three finite numbers within 1e9 m");
    }

    std::shared_ptr<const Model> model;
    Front front;
    Adaptivity adaptivity;
    AdaptivitySettings adapt_settings;
    ElementSet elements;
    Implicit implicit;
    ImplicitSettings settings;
    State state;
    FrameBuilder frames;
    PerVertex<std::uint8_t> pinned;  // [V] as Model::pinned, without what the timeline has released
    bool has_pins;
    Vec3 gravity;
    std::map<std::uint64_t, Pull> pulls;
    double time = 0;
    std::uint64_t steps = 0;
    std::size_t budget_tets = 0;
    double budget_milliseconds = 0;   // 0: none
    double milliseconds_per_tet = 0;  // of recent steps, the costliest
    StepReport report;
    std::vector<std::array<Vec3, 3>> saved;  // x, v and a of the front's vertices before the step
    PerVertex<Vec3> scratch;
    std::chrono::steady_clock::time_point phase_start;
};

Simulation::Simulation(std::shared_ptr<const Model> model, const FrontSpec& front)
    : impl_(std::make_unique<Impl>(std::move(model), front)) {}
Simulation::Simulation(std::shared_ptr<const Model> model) {
    const FrontSpec front = model->scene.front;
    impl_ = std::make_unique<Impl>(std::move(model), front);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

StepReport Simulation::step() { return impl_->step(); }

void Simulation::reset() {
    Impl& s = *impl_;
    s.pulls.clear();
    const TetTree& tree = s.model->tree;
    for (int level = tree.depth() - 1; level >= s.front.min_level(); --level) {
        std::vector<TetId> parents;
        for (TetId t : s.front.active())
            if (tree.level_of(t) == level + 1 && tree.child_number(t) == 0) parents.push_back(tree.parent(t));
        for (TetId p : parents)
            if (s.front.can_merge(p)) s.front.merge(p);
        s.front.commit();
    }
    s.start();
}

std::shared_ptr<const Frame> Simulation::frame(double steps_per_second, Field field) {
    Impl& s = *impl_;
    FrameStatus status;
    status.time = s.time;
    status.step = s.steps;
    status.estimate = s.report.estimate;
    status.tolerance = s.adapt_settings.tolerance;
    status.step_milliseconds = s.report.milliseconds.total();
    status.steps_per_second = steps_per_second;
    status.free_vertices = s.report.free_vertices;
    status.solver_iterations = static_cast<std::uint32_t>(s.report.solver_iterations);
    status.converged = s.report.converged;
    status.warning = s.report.warning;
    std::vector<FramePull> pulls;
    const Loads loads = s.loads();
    auto spring = loads.springs.begin();  // one for each pull, in order
    for (const auto& [id, target] : s.pulls) {
        const Vec3 from = s.position(spring->at);
        FramePull pull;
        for (int c = 0; c < 3; ++c) {
            pull.from[static_cast<std::size_t>(c)] = static_cast<float>(from[c]);
            pull.to[static_cast<std::size_t>(c)] = static_cast<float>(target.target[c]);
        }
        pull.force = static_cast<float>(spring->stiffness * (spring->target - from).norm());
        pulls.push_back(pull);
        ++spring;
    }
    const std::shared_ptr<Frame> frame = s.frames.build(s.front, s.state.x, std::move(status), std::move(pulls));
    frame->field = field;
    frame->field_values = surface_field(
        field, {s.front, s.elements, s.adaptivity, s.model->matrices, s.model->surface, frame->surface, s.frames.points()});
    return frame;
}

const Model& Simulation::model() const { return *impl_->model; }
const Front& Simulation::front() const { return impl_->front; }

void Simulation::begin_pull(std::uint64_t pull, const SurfacePoint& point, const Vec3& target) { impl_->begin_pull(pull, point, target); }

void Simulation::move_pull(std::uint64_t pull, const Vec3& target) {
    Impl::check_target(target);
    const auto it = impl_->pulls.find(pull);
    if (it != impl_->pulls.end()) it->second.target = target;
}

void Simulation::end_pull(std::uint64_t pull) { impl_->pulls.erase(pull); }

void Simulation::set_gravity(const Vec3& gravity) {
    if (!gravity.allFinite() || gravity.cwiseAbs().maxCoeff() > 1e4)
        throw InputError("", "/value", "is not a gravity", "use three finite numbers within 1e4 m/s^2");
    impl_->gravity = gravity;
}

void Simulation::set_tolerance(double tolerance) {
    if (!(tolerance > 0 && tolerance <= 1)) throw InputError("", "/value", "is not a tolerance", "use a number in (0, 1]");
    impl_->adapt_settings.tolerance = tolerance;
}

void Simulation::set_budget(std::size_t tets, double milliseconds) {
    if (tets == 0) throw InputError("", "/tets", "is 0", "use a number of tets from 1");
    if (!(milliseconds >= 0 && milliseconds <= 1e6))
        throw InputError("", "/milliseconds", "is not a budget", "use a number from 0 (no limit) to 1e6");
    impl_->budget_tets = tets;
    impl_->budget_milliseconds = milliseconds;
}

PerVertex<Vec3> Simulation::all_positions() const {
    const Front& front = impl_->front;
    PerVertex<Vec3> x = impl_->state.x;
    for (VertexId v : ids<VertexId>(x.size()))
        if (front.state(v) == VertexState::absent) x[v] = front.interpolate(x, v);
    return x;
}

ElementSet::Momentum Simulation::momentum() const { return impl_->elements.momentum(impl_->state.x, impl_->state.v); }

Simulation::Energy Simulation::energy() const {
    return {impl_->elements.kinetic_energy(impl_->state.v), impl_->elements.energy()};
}

std::uint64_t Simulation::hash() const {
    const Impl& s = *impl_;
    Hash hash;
    hash.add(s.steps);
    for (TetId t : s.front.active()) hash.add(t.value);
    for (VertexId v : s.front.vertices())
        for (const PerVertex<Vec3>* field : {&s.state.x, &s.state.v, &s.state.a}) hash.add_bytes((*field)[v].data(), 3 * sizeof(double));
    return hash.value();
}

}  // namespace tetfront
