#pragma once
// The ground of a scene that asks for one: which points of the object can touch it, and how hard it pushes.
//
// What touches is the smooth surface, by a few points of every active tet: those of the tet's points of the surface that stick
// out farthest in fourteen directions; of a quadratic tet's eight children, as it bends between its corners. They are chosen
// once for every tet of the tree, from the leaves up, so a step looks at the front's tets only, and a coarse tet rests on few
// points. The push of a tet's points together is that of a block of its material as large as the tet, so what the object
// sinks in is about what the tet gets squeezed. What friction holds creeps: by up to an eighth of friction's coefficient times
// that depth in a step.
//
//     const Ground ground(spec, up, size, tree, surface);                    // once
//     ground.add_contacts(loads, front, matrices, state, time_step);        // each step
//
// Nothing has to be remembered between steps: the force that friction is in proportion to follows from the depth that a
// step begins with.

#include <span>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/elasticity.hpp"
#include "engine/mechanics/state.hpp"
#include "engine/scene/scene.hpp"
#include "engine/tree/surface.hpp"

namespace tetfront {

class Ground {
 public:
    /// up: axis of its normal. size: [m] of the object. Cost: the tree and the surface.
    Ground(const GroundSpec& spec, int up, double size, const TetTree& tree, const Surface& surface);

    /// Adds the points that are below the ground or may get there within time_step [s]. Cost: the front. matrices:
    /// those that are simulated with.
    void add_contacts(Loads& loads, const Front& front, const ElasticityMatrices& matrices, const State& state, double time_step) const;

    /// Everything that could touch it: the surface's vertices, then points inside of triangles that are larger than leaves.
    [[nodiscard]] const std::vector<Attachment>& attachments() const { return attachment_; }
    /// Those of any tet that can touch it, into attachments().
    [[nodiscard]] std::span<const std::uint32_t> points(TetId t) const {
        return {vertices_.data() + begin_[t.index()], vertices_.data() + begin_[t.index() + 1]};
    }

 private:
    GroundSpec spec_;
    int up_;
    double size_;
    std::vector<std::uint32_t> begin_;     // [tets of the tree + 1]
    std::vector<std::uint32_t> vertices_;  // into attachment_
    std::vector<Attachment> attachment_;
};

}  // namespace tetfront
