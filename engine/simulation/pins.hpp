#pragma once
// Which vertices do not move at the moment: the model's pinned ones without what the timeline has released.
//
//     Pins pins(*model);
//     pins.hold(steps, time_step);                  // by the timeline, for a step number
//     if (pins.pinned[v]) ...

#include "engine/simulation/simulation.hpp"

namespace tetfront {

/// The step before which an event of the timeline takes place: the one whose start is nearest.
std::uint64_t step_of(const TimelineEvent& event, double time_step);

struct Pins {
    explicit Pins(const Model& model) : pinned(model.pinned), any(model.has_pins) {}

    /// Pins every vertex of the pins that are not released by step `steps`; it follows from that alone. Cost: the tree.
    void hold(const Model& model, std::uint64_t steps, double time_step);

    PerVertex<std::uint8_t> pinned;  // [V] nonzero: does not move
    bool any;
};

}  // namespace tetfront
