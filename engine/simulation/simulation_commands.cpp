// Commands and answers; what a step does is in simulation_step.cpp.
#include "engine/simulation/simulation.hpp"

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/simulation/simulation_impl.hpp"
#include "engine/simulation/surface_field.hpp"

namespace tetfront {

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
StepReport Simulation::settle() { return impl_->settle(); }

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
    status.phases = s.report.milliseconds;
    status.kinetic_energy = s.elements.kinetic_energy(s.state.v);
    status.elastic_energy = s.elements.energy();
    status.steps_per_second = steps_per_second;
    status.free_vertices = s.report.free_vertices;
    status.solver_iterations = static_cast<std::uint32_t>(s.report.solver_iterations);
    status.converged = s.report.converged;
    status.warning = s.report.warning;
    const std::shared_ptr<Frame> frame = s.frames.build(s.front, s.state.x, std::move(status), s.pulls.seen(s.front, *s.model, s.state.x));
    frame->forces = s.seen_forces();
    frame->field = field;
    FieldValues values = surface_field(
        field, {s.front, s.elements, s.adaptivity, s.matrices(), s.model->surface, frame->surface, s.frames.points(),
                frame->front_positions});
    frame->field_values = std::move(values.surface);
    frame->front_values = std::move(values.front);
    return frame;
}

void Simulation::number_fronts_from(std::uint32_t epoch) { impl_->frames.number_from(epoch); }
const Model& Simulation::model() const { return *impl_->model; }
const Front& Simulation::front() const { return impl_->front; }

void Simulation::begin_pull(std::uint64_t pull, const SurfacePoint& point, const Vec3& target) {
    impl_->pulls.begin(pull, *impl_->model, point, target);
}
void Simulation::move_pull(std::uint64_t pull, const Vec3& target) { impl_->pulls.move(pull, target); }
void Simulation::end_pull(std::uint64_t pull) { impl_->pulls.end(pull); }

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

void Simulation::set_order(int order) {
    if (order != 1 && order != 2) throw InputError("", "/value", "is no order of tets", "use 1 or 2");
    if (order == 2 && impl_->model->tree.depth() == 0)
        throw InputError("", "/value", "needs vertices inside of tets", "use a scene with levels of 1 or more");
    FrontSpec wanted = impl_->front_spec;
    wanted.order = order;
    impl_->set_front(wanted);
}

void Simulation::set_levels(int min_level, int max_level) {
    if (min_level < 0 || min_level > max_level) throw InputError("", "/min", "is not a level up to max", "use 0 <= min <= max");
    FrontSpec wanted = impl_->front_spec;
    wanted.min_level = min_level;
    wanted.max_level = max_level;
    impl_->set_front(wanted);
}

void Simulation::set_edits(const Edits& edits) { impl_->set_edits(edits); }
const Edits& Simulation::edits() const { return impl_->edits; }

PerVertex<Vec3> Simulation::all_positions() const {
    PerVertex<Vec3> x = impl_->state.x;
    interpolate_absent(impl_->front, x);
    return x;
}

void Simulation::place(const PerVertex<Vec3>& x, const PerVertex<Vec3>& v) {
    Impl& s = *impl_;
    const std::size_t n = s.model->tree.vertex_count();
    if (x.size() != n || v.size() != n) throw InputError("", "/place", "does not have one vector for each vertex of the tree", "use " + std::to_string(n));
    for (VertexId i : s.front.vertices())
        if (!x[i].allFinite() || !v[i].allFinite()) throw InputError("", "/place", "is not finite", "use finite positions and velocities");
    s.place(x, v);
}

Momentum Simulation::momentum() const { return impl_->elements.momentum(impl_->state.x, impl_->state.v); }

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
    if (s.settings.rule == ImplicitRule::bdf2 && s.state.has_earlier) {
        for (VertexId v : s.front.vertices())
            for (const PerVertex<Vec3>* field : {&s.state.earlier_x, &s.state.earlier_v}) hash.add_bytes((*field)[v].data(), 3 * sizeof(double));
    }
    return hash.value();
}

}  // namespace tetfront
