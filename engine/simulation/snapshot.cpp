#include "engine/simulation/snapshot.hpp"

#include <algorithm>
#include <array>
#include <functional>

#include "engine/base/atomic_file.hpp"
#include "engine/base/bytes.hpp"
#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/base/overloaded.hpp"
#include "engine/mesh/file_bytes.hpp"

namespace tetfront {

namespace {

/// Bump whenever the layout below changes, or what a step makes of the same state.
constexpr std::uint32_t format_version = 2;
constexpr std::array<char, 8> magic = {'t', 'e', 't', 'f', 'r', 'S', '\r', '\n'};
constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 33;
/// No state of a scene comes near it, and nothing that a step computes of it overflows.
constexpr double largest_number = 1e30;

std::uint64_t checksum(std::uint64_t model, std::string_view payload) {
    return Hash().add(format_version).add(model).add(payload).value();
}

void add(Hash& hash, const Vec3& v) { hash.add_bytes(v.data(), 3 * sizeof(double)); }

void add(Hash& hash, const Region& region) {
    hash.add(region.index());
    std::visit(Overloaded{[&](const Box& b) {
                              add(hash, b.low);
                              add(hash, b.high);
                          },
                          [&](const HalfSpace& h) {
                              add(hash, h.point);
                              add(hash, h.normal);
                          },
                          [&](const Sphere& s) {
                              add(hash, s.centre);
                              hash.add(s.radius);
                          }},
               region);
}

void add(Hash& hash, const Scene& scene, const FrontSpec& front) {
    add(hash, scene.gravity);
    hash.add(scene.pins.size());
    for (const Region& region : scene.pins) add(hash, region);
    hash.add(scene.timeline.size());
    for (const TimelineEvent& event : scene.timeline) {
        hash.add(event.time).add(event.gravity.has_value()).add(event.release.value_or(-1));
        if (event.gravity) add(hash, *event.gravity);
    }
    hash.add(scene.ground.has_value());
    if (scene.ground) hash.add(scene.ground->height).add(scene.ground->friction);
    hash.add(scene.time_step);
    const SolverSpec& solver = scene.solver;
    hash.add(solver.scheme).add(solver.start).add(solver.strain).add(solver.newton_iterations).add(solver.newton_tolerance).add(solver.cg_tolerance).add(solver.cg_iterations);
    hash.add(front.order).add(front.min_level).add(front.max_level);
    hash.add(front.tolerance).add(front.budget_tets).add(front.budget_milliseconds);
}

template <class T>
void add(Hash& hash, const PooledPerTet<T>& pooled) {
    hash.add(pooled.numbers().size()).add_range(pooled.numbers());
    hash.add_bytes(pooled.values().data(), pooled.values().size() * sizeof(T));
}

/// The fields between the header and the end, in order; false as soon as one of the two functions says so.
template <class Snapshot, class Value, class Range>
bool visit_fields(Snapshot& s, const Value& value, const Range& range) {
    return range(s.scene) && value(s.steps) && value(s.time) && value(s.gravity) && value(s.tolerance) && value(s.budget_tets) &&
           value(s.budget_milliseconds) && value(s.milliseconds_per_tet) && range(s.active) && range(s.motion) && value(s.has_earlier) && range(s.pulls) &&
           value(s.reference_energy) && range(s.rests) && value(s.solver_iterations) && value(s.converged) && value(s.rejected) &&
           range(s.warning);
}

/// Each number within what any state may have.
bool in_range(const Snapshot& s) {
    const auto within = [](double x, double low, double high) { return low <= x && x <= high; };  // false for NaN
    const auto all = [&](const auto& values, double most) {
        return std::ranges::all_of(values, [&](double x) { return within(x, -most, most); });
    };
    const auto ascending = [](const auto& values, auto key) {
        return std::ranges::adjacent_find(values, std::ranges::greater_equal{}, key) == values.end();
    };
    return s.scene.size() <= 4096 && s.warning.size() <= 4096 && s.steps < std::uint64_t{1} << 53 && within(s.time, 0, 1e18) &&
           all(s.gravity, 1e4) && s.tolerance > 0 && s.tolerance <= 1 && s.budget_tets >= 1 && within(s.budget_milliseconds, 0, 1e6) &&
           within(s.milliseconds_per_tet, 0, 1e9) && within(s.reference_energy, 0, 1e100) && s.solver_iterations >= 0 &&
           s.has_earlier <= 1 && s.converged <= 1 && s.rejected <= 1 && ascending(s.active, std::identity{}) &&
           ascending(s.pulls, &Snapshot::Pull::id) && ascending(s.rests, [](const auto& rest) { return rest[0]; }) &&
           std::ranges::all_of(s.motion, [&](const auto& m) { return all(m, largest_number); }) &&
           std::ranges::all_of(s.pulls, [&](const Snapshot::Pull& p) { return all(p.target, 1e9) && all(p.barycentric, 1e6); });
}

}  // namespace

std::uint64_t model_hash(const Model& model, const FrontSpec& front) {
    Hash hash;
    const TetTree& tree = model.tree;
    hash.add(tree.depth()).add(tree.root_count());
    hash.add_bytes(tree.rest().data(), tree.vertex_count(0) * sizeof(Vec3));
    for (TetId t : tree.level(0)) hash.add_bytes(tree.corners(t).data(), sizeof tree.corners(t));
    add(hash, model.matrices.elasticity);
    add(hash, model.matrices.bracket);
    add(hash, model.matrices.valid_range);
    for (const PerTet<double>* values : {&model.density, &model.matrices.mass_damping, &model.matrices.stiffness_damping})
        hash.add_range(*values);
    hash.add_range(model.pinned);
    hash.add(model.forces.size());
    for (const AttachedForce& f : model.forces) {
        hash.add(f.at.leaf.value).add_bytes(f.at.barycentric.data(), 4 * sizeof(double)).add(f.start).add(f.end);
        add(hash, f.force);
    }
    if (model.ground) {
        hash.add(model.scene.up);
        for (const Attachment& at : model.ground->attachments()) hash.add(at.leaf.value).add_bytes(at.barycentric.data(), 4 * sizeof(double));
    }
    add(hash, model.scene, front);
    return hash.value();
}

std::string encode(const Snapshot& snapshot) {
    ByteWriter payload;
    visit_fields(
        snapshot,
        [&](const auto& field) {
            payload.put(field);
            return true;
        },
        [&](const auto& field) {
            payload.put_range(field);
            return true;
        });
    ByteWriter out;
    out.put(magic);
    out.put(format_version);
    out.put(std::uint32_t{0});
    out.put(snapshot.model);
    out.put(checksum(snapshot.model, payload.bytes()));
    out.put_range(payload.bytes());
    return out.bytes();
}

Snapshot decode(std::string_view bytes, const std::string& name) {
    const auto refuse = [&](const std::string& problem, const char* remedy = "use another one, or start from the beginning") {
        throw InputError(name, "snapshot", problem, remedy);
    };
    ByteReader in(bytes);
    std::array<char, 8> first{};
    std::uint32_t version = 0, zero = 0;
    std::uint64_t sum = 0, length = 0;
    Snapshot s;
    if (!in.get(first) || first != magic) refuse("is no state of a simulation", "use a file that `tetfront run --save` made");
    if (!in.get(version) || !in.get(zero)) refuse("is cut short");
    if (version != format_version)
        refuse("has format version " + std::to_string(version) + ", not " + std::to_string(format_version));
    if (!in.get(s.model) || !in.get(sum) || !in.get(length) || in.rest().size() < length) refuse("is cut short");
    if (in.rest().size() != length || zero != 0 || sum != checksum(s.model, in.rest())) refuse("is damaged");
    const bool read = visit_fields(
        s, [&](auto& field) { return in.get(field); }, [&](auto& field) { return in.get_range(field); });
    if (!read || !in.done() || !in_range(s)) refuse("is damaged");
    return s;
}

void save_snapshot(const std::filesystem::path& file, const Simulation& simulation) { write_atomically(file, simulation.snapshot()); }

std::uint64_t load_snapshot(const std::filesystem::path& file, Simulation& simulation) {
    const std::string bytes = read_bytes(file, largest_file);
    simulation.restore(bytes, file.string());
    return decode(bytes, file.string()).steps;
}

}  // namespace tetfront
