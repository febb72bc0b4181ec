// From the simulation's state to a Snapshot and back.
#include <algorithm>
#include <optional>

#include "engine/base/error.hpp"
#include "engine/simulation/simulation_impl.hpp"

namespace tetfront {

namespace {

Vec3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// In the order of Snapshot::motion.
auto fields(auto& state) { return std::array{&state.x, &state.v, &state.a, &state.earlier_x, &state.earlier_v}; }

}  // namespace

Snapshot Simulation::Impl::snapshot() const {
    Snapshot s;
    s.model = model_hash(*model, front_spec);
    s.scene = model->scene.name;
    s.steps = steps;
    s.time = time;
    std::ranges::copy(gravity, s.gravity.begin());
    s.tolerance = adapt_settings.tolerance;
    s.budget_tets = budget_tets;
    s.budget_milliseconds = budget_milliseconds;
    s.milliseconds_per_tet = budget_milliseconds > 0 ? milliseconds_per_tet : 0;
    s.active = front.active();
    s.motion.reserve(front.vertices().size());
    for (VertexId v : front.vertices()) {
        auto out = s.motion.emplace_back().begin();
        for (const PerVertex<Vec3>* field : fields(state)) out = std::ranges::copy((*field)[v], out).out;
    }
    s.has_earlier = state.has_earlier;
    for (const auto& [id, pull] : pulls.all()) {
        Snapshot::Pull& p = s.pulls.emplace_back(Snapshot::Pull{id, pull.at.leaf.value, {}, {}});
        std::ranges::copy(pull.at.barycentric, p.barycentric.begin());
        std::ranges::copy(pull.target, p.target.begin());
    }
    const Adaptivity::Memory memory = adaptivity.memory(steps);
    s.reference_energy = memory.reference_energy;
    for (const auto& [tet, until] : memory.rests) s.rests.push_back({static_cast<std::uint64_t>(tet.value), until});
    s.solver_iterations = report.solver_iterations;
    s.converged = report.converged;
    s.rejected = report.rejected;
    s.warning = report.warning;
    return s;
}

/// Holds all of it against the model first, and changes everything then.
void Simulation::Impl::restore(const Snapshot& s, const std::string& name) {
    const auto refuse = [&](const std::string& problem, const char* remedy) { throw InputError(name, "snapshot", problem, remedy); };
    if (s.model != model_hash(*model, front_spec)) {
        refuse("belongs to " + (s.scene == model->scene.name ? "other settings of this scene" : "scene \"" + s.scene + "\""),
               "use the scene and the settings that it was saved with");
    }
    const TetTree& tree = model->tree;
    std::optional<Front> restored = front.with_active(s.active);
    bool fits = restored && restored->vertices().size() == s.motion.size();
    for (const Snapshot::Pull& pull : s.pulls)
        fits = fits && 0 <= pull.leaf && pull.leaf < static_cast<std::int64_t>(tree.tet_count()) && tree.is_leaf(TetId(pull.leaf));
    Adaptivity::Memory memory{s.reference_energy, {}};
    for (const auto& [tet, until] : s.rests) {
        fits = fits && tet < tree.tet_count();
        memory.rests.push_back({TetId(static_cast<std::int64_t>(tet)), until});
    }
    if (!fits) refuse("does not fit its model", "use another one, or start from the beginning");

    front = std::move(*restored);
    for (std::size_t i = 0; i < s.motion.size(); ++i) {
        const double* in = s.motion[i].data();
        for (PerVertex<Vec3>* field : fields(state)) {
            (*field)[front.vertices()[i]] = Vec3(in[0], in[1], in[2]);
            in += 3;
        }
    }
    state.has_earlier = s.has_earlier != 0;
    steps = s.steps;
    time = s.time;
    gravity = vector(s.gravity);
    adapt_settings.tolerance = s.tolerance;
    budget_tets = s.budget_tets;
    budget_milliseconds = s.budget_milliseconds;
    milliseconds_per_tet = s.milliseconds_per_tet;
    pulls.clear();
    for (const Snapshot::Pull& p : s.pulls) {
        const auto& b = p.barycentric;
        pulls.set(p.id, {{TetId(p.leaf), Vec4(b[0], b[1], b[2], b[3])}, vector(p.target)});
    }
    pins.hold(*model, edits.pins, steps, settings.time_step);
    rebuild();
    elements.evaluate({.x = state.x});
    adaptivity.set_memory(memory);
    const double kinetic = pins.firm ? elements.kinetic_energy(state.v) : 0;
    adaptivity.measure(front, elements, state.x, 0, kinetic, adapt_settings);
    report = {};
    report.solver_iterations = s.solver_iterations;
    report.converged = s.converged != 0;
    report.rejected = s.rejected != 0;
    report.warning = s.warning;
    describe(report);
}

std::string Simulation::snapshot() const { return encode(impl_->snapshot()); }

void Simulation::restore(std::string_view snapshot, const std::string& name) { impl_->restore(decode(snapshot, name), name); }

}  // namespace tetfront
