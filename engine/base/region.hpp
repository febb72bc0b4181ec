#pragma once
// Parts of space that scenes speak of: what is pinned, where a force acts, what is made of which material.
//
//     Region grip = Box{{0, 0, 0}, {0.1, 1, 1}};
//     if (contains(grip, p)) ...

#include "engine/base/types.hpp"

#include <variant>

namespace tetfront {

struct Box {
    Vec3 low, high;  // [m] low < high along each axis; its surface is part of it
};
/// Points p with (p - point) . normal <= 0.
struct HalfSpace {
    Vec3 point;   // [m]
    Vec3 normal;  // any length above 0
};
struct Sphere {
    Vec3 centre;    // [m]
    double radius;  // [m] > 0
};
using Region = std::variant<Box, HalfSpace, Sphere>;

inline bool contains(const Box& box, const Vec3& p) {
    return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}
inline bool contains(const HalfSpace& half, const Vec3& p) { return (p - half.point).dot(half.normal) <= 0; }
inline bool contains(const Sphere& sphere, const Vec3& p) {
    return (p - sphere.centre).squaredNorm() <= sphere.radius * sphere.radius;
}
inline bool contains(const Region& region, const Vec3& p) {
    return std::visit([&](const auto& r) { return contains(r, p); }, region);
}

}  // namespace tetfront
