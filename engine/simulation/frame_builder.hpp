#pragma once
// Makes Frames: evaluates the embedded surface on the front and describes the front for wireframes and cuts.
//
//     FrameBuilder builder(model, surface, matrices);
//     auto frame = builder.build(front, x, status, pulls);   // topology is shared until the front changes

#include <memory>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/elasticity.hpp"
#include "engine/simulation/frame.hpp"
#include "engine/tree/front.hpp"
#include "engine/tree/surface.hpp"

namespace tetfront {

class FrameBuilder {
 public:
    /// surface and matrices must outlive this.
    FrameBuilder(std::shared_ptr<const FrameModel> model, const Surface& surface, const ElasticityMatrices& matrices);

    /// x: positions of the front's vertices. Cost: the surface and, after a change, the front.
    std::shared_ptr<Frame> build(const Front& front, const PerVertex<Vec3>& x, FrameStatus status,
                                 std::vector<FramePull> pulls);
    /// The next build() is of another front, whatever its epoch.
    void forget_front() { topology_.reset(); }
    /// Topologies to come have greater epochs than this.
    void number_from(std::uint32_t epoch) { epochs_made_ = epoch; }
    /// [S] the surface's vertices in the front of the last build().
    [[nodiscard]] const std::vector<Front::Point>& points() const { return points_; }

 private:
    void rebuild(const Front& front);

    std::shared_ptr<const FrameModel> model_;
    const Surface* surface_;
    const ElasticityMatrices* matrices_;
    std::shared_ptr<const FrameTopology> topology_;
    std::uint32_t front_epoch_ = 0, epochs_made_ = 0;
    std::vector<Front::Point> points_;  // [S] surface vertices in the front
};

}  // namespace tetfront
