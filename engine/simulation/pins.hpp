#pragma once
// Which vertices do not move at the moment: the model's pinned ones without what the timeline has released, and what
// users have pinned and unpinned since.
//
//     Pins pins(*model);
//     pins.hold(*model, edits.pins, steps, time_step);    // by the timeline, for a step number
//     if (pins.pinned[v]) ...

#include "engine/simulation/simulation.hpp"

namespace tetfront {

/// The step before which an event of the timeline takes place: the one whose start is nearest.
std::uint64_t step_of(const TimelineEvent& event, double time_step);

/// Tets that contain pinned vertices although none of their own corners is pinned: their descendants know better.
PerTet<std::uint8_t> find_unresolved(const TetTree& tree, const PerVertex<std::uint8_t>& pinned);
/// Whether three pinned vertices are far from one line, so that no rigid motion is left. size: [m] of the object.
bool pins_hold(const TetTree& tree, const PerVertex<std::uint8_t>& pinned, double size);

struct Pins {
    explicit Pins(const Model& model) : pinned(model.pinned), unresolved(model.unresolved), any(model.has_pins), firm(model.held) {}

    enum Kind : std::uint8_t { unpinned, at_rest, in_place };

    /// Pins every vertex of the pins that are not released by step `steps`, then follows the edits. Cost: the tree.
    void hold(const Model& model, const std::vector<PinEdit>& edits, std::uint64_t steps, double time_step);

    PerVertex<std::uint8_t> pinned;  // [V] a Kind: at_rest stays at its rest position, in_place wherever it is
    PerTet<std::uint8_t> unresolved;  // [T] as Model::unresolved, for the present pins
    bool any;
    bool firm;  // as Model::held
};

}  // namespace tetfront
