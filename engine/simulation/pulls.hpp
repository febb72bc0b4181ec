#pragma once
// What viewers pull at: springs between points of the surface and cursors, safe in anybody's hands. A pull is critically
// damped for the object as a whole, and acts as if never longer than half of the object's size; then it accelerates the
// object with 50 m/s^2, whatever its size and mass. So no drag can blow a scene up.
//
//     Pulls pulls;
//     pulls.begin(1, *model, {triangle, barycentric}, target);
//     pulls.add_to(loads, front, *model, x);

#include <map>

#include "engine/mechanics/state.hpp"
#include "engine/simulation/simulation.hpp"

namespace tetfront {

struct Pull {
    Attachment at;
    Vec3 target;  // [m]
};

/// Where a surface point sits in the leaves. Throws InputError for what is no point of the surface.
Attachment attach(const Model& model, const SurfacePoint& point);
/// Where it is at rest [m].
Vec3 rest_position(const Model& model, const SurfacePoint& point);

class Pulls {
 public:
    /// Throw InputError for a point that is none of the surface's and for a target that is no position, and change nothing.
    void begin(std::uint64_t id, const Model& model, const SurfacePoint& point, const Vec3& target);
    void move(std::uint64_t id, const Vec3& target);  // unknown: nothing
    void end(std::uint64_t id) { pulls_.erase(id); }
    void clear() { pulls_.clear(); }
    [[nodiscard]] const std::map<std::uint64_t, Pull>& all() const { return pulls_; }
    /// Sets one as all() had it.
    void set(std::uint64_t id, const Pull& pull) { pulls_[id] = pull; }

    /// Adds one spring for each pull, in the order of their ids. x: positions of the front's vertices.
    void add_to(Loads& loads, const Front& front, const Model& model, const PerVertex<Vec3>& x) const;
    /// What frames show of them.
    [[nodiscard]] std::vector<FramePull> seen(const Front& front, const Model& model, const PerVertex<Vec3>& x) const;

 private:
    std::map<std::uint64_t, Pull> pulls_;
};

}  // namespace tetfront
