#include "engine/simulation/pins.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

std::uint64_t step_of(const TimelineEvent& event, double time_step) {
    return static_cast<std::uint64_t>(std::llround(event.time / time_step));
}

void Pins::hold(const Model& model, std::uint64_t steps, double time_step) {
    std::vector<Region> held;
    for (std::size_t i = 0; i < model.scene.pins.size(); ++i) {
        const auto released = [&](const TimelineEvent& e) {
            return e.release && static_cast<std::size_t>(*e.release) == i && step_of(e, time_step) <= steps;
        };
        if (std::ranges::none_of(model.scene.timeline, released)) held.push_back(model.scene.pins[i]);
    }
    any = false;
    for (VertexId v : ids<VertexId>(pinned.size())) {
        if (!model.pinned[v]) continue;
        pinned[v] = std::ranges::any_of(held, [&](const Region& r) { return contains(r, model.tree.rest(v)); });
        any = any || pinned[v];
    }
}

}  // namespace tetfront
