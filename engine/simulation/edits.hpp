#pragma once
// What users have changed of a running simulation beyond its scene, as plain data: forces, pins, stiffness, damping.
//
//     Edits edits = simulation.edits();
//     edits.stiffness_scale = 2, edits.stiffness.push_back({point, 0.02, 10});
//     edits.forces[7] = {{triangle, barycentric}, {0, 0, -5}};
//     edits.pins.push_back({true, point, 0.02});
//     simulation.set_edits(edits);

#include <cstdint>
#include <map>
#include <vector>

#include "engine/base/types.hpp"

namespace tetfront {

/// A point of the surface: triangle of FrameModel::triangles and barycentric coordinates in it (>= 0, sum 1).
struct SurfacePoint {
    std::uint32_t triangle = 0;
    Vec3 barycentric = Vec3::Constant(1.0 / 3);
    friend bool operator==(const SurfacePoint&, const SurfacePoint&) = default;
};

/// What is within `radius` of this point of the object at rest stays where it is from now on, or becomes free.
struct PinEdit {
    bool pinned = true;
    SurfacePoint centre;
    double radius = 0;  // [m] >= 0
    friend bool operator==(const PinEdit&, const PinEdit&) = default;
};

/// Leaves whose middle is within `radius` of this point of the object at rest are `scale` times as stiff as the scene says.
struct StiffnessEdit {
    SurfacePoint centre;
    double radius = 0;  // [m] >= 0
    double scale = 1;   // 0.01..100
    friend bool operator==(const StiffnessEdit&, const StiffnessEdit&) = default;
};

struct SurfaceForce {
    SurfacePoint at;
    Vec3 value = Vec3::Zero();  // [N]
    friend bool operator==(const SurfaceForce&, const SurfaceForce&) = default;
};

struct Edits {
    double stiffness_scale = 1;    // 0.01..100, times every elasticity matrix
    std::vector<StiffnessEdit> stiffness;  // on top of that; the last one that holds a leaf counts
    double mass_damping = 0;       // 0..1000 [1/s] added to every material's Rayleigh coefficient
    double stiffness_damping = 0;  // 0..10 [s] the same
    std::vector<PinEdit> pins;     // in the order in which they were made: the last word on a vertex counts
    std::map<std::uint32_t, SurfaceForce> forces;  // by number
    friend bool operator==(const Edits&, const Edits&) = default;
};

}  // namespace tetfront
