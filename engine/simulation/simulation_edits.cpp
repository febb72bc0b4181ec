// Commands that change what is simulated while it moves: edits beyond the scene, and the order of the tets.
#include "engine/base/error.hpp"
#include "engine/simulation/edited_materials.hpp"
#include "engine/simulation/pulls.hpp"
#include "engine/simulation/simulation_impl.hpp"

namespace tetfront {

namespace {

void check(bool good, const char* where, const char* remedy) {
    if (!good) throw InputError("", where, "is out of range", remedy);
}

}  // namespace

void interpolate_absent(const Front& front, PerVertex<Vec3>& field) {
    for (VertexId v : ids<VertexId>(field.size()))
        if (front.state(v) == VertexState::absent) field[v] = front.interpolate(field, v);
}

void Simulation::Impl::set_edits(const Edits& wanted) {
    const auto check_scale = [](double scale) { check(scale >= 0.01 && scale <= 100, "/value", "use a scale of 0.01 to 100"); };
    const auto check_place = [&](const SurfacePoint& centre, double radius) {
        check(radius >= 0 && radius <= 1e6, "/radius", "use 0 to 1e6 m");
        rest_position(*model, centre);
    };
    check_scale(wanted.stiffness_scale);
    check(wanted.mass_damping >= 0 && wanted.mass_damping <= 1000, "/mass", "use 0 to 1000 1/s");
    check(wanted.stiffness_damping >= 0 && wanted.stiffness_damping <= 10, "/stiffness", "use 0 to 10 s");
    std::vector<PointLoad> forces;
    for (const auto& [number, force] : wanted.forces) {
        check(force.value.allFinite() && force.value.cwiseAbs().maxCoeff() <= 1e9, "/value", "use three numbers within 1e9 N");
        forces.push_back({attach(*model, force.at), force.value});
    }
    for (const PinEdit& pin : wanted.pins) check_place(pin.centre, pin.radius);
    for (const StiffnessEdit& edit : wanted.stiffness) check_scale(edit.scale), check_place(edit.centre, edit.radius);
    const Edits before = std::exchange(edits, wanted);
    edit_forces = std::move(forces);
    const bool other_materials = before.stiffness_scale != edits.stiffness_scale || before.stiffness != edits.stiffness ||
                                 before.mass_damping != edits.mass_damping || before.stiffness_damping != edits.stiffness_damping;
    const bool other_pins = before.pins != edits.pins;
    if (!other_materials && !other_pins) return;
    if (other_materials) {
        edited_matrices = edited_materials(*model, edits);
        const double scale = edits.stiffness_scale / before.stiffness_scale;
        adapt_settings.energy_floor *= scale;
        adaptivity = Adaptivity(matrices(), pins.unresolved);
        stepper.forget_materials();
    }
    if (other_pins) {
        pins.hold(*model, edits.pins, steps, settings.time_step);
        resolve_pins();
    }
    rebuild();
    measure_anew();
}

void Simulation::Impl::set_front(const FrontSpec& wanted) {
    const TetTree& tree = model->tree;
    Front next(tree, wanted.order, wanted.min_level, wanted.max_level);
    front_spec = wanted;
    if (next.order() == front.order() && next.min_level() == front.min_level() && next.max_level() == front.max_level()) return;
    for (PerVertex<Vec3>* field : {&state.x, &state.v, &state.a, &state.earlier_x, &state.earlier_v}) interpolate_absent(front, *field);
    // Splits that lead to what was active; deeper levels than it may have are left out.
    PerTet<std::uint8_t> above(tree.tet_count(), 0);
    for (TetId t : front.active())
        for (TetId up = t; tree.level_of(up) > 0;) above[up = tree.parent(up)] = 1;
    for (int level = 0; level < tree.depth(); ++level)
        for (TetId t : tree.level(level))
            if (above[t] && next.is_active(t)) next.split(t);
    next.commit();
    front = std::move(next);
    front.prolong(state.x), front.prolong(state.v), front.prolong(state.a);
    front.prolong(state.earlier_x), front.prolong(state.earlier_v);
    frames.forget_front();
    stepper.forget_materials();
    resolve_pins();
    adaptivity = Adaptivity(matrices(), pins.unresolved);
    rebuild();
    measure_anew();
}

}  // namespace tetfront
