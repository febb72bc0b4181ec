#pragma once
// Contact of a point of the front with the ground, a half-space n . x <= height, and Coulomb friction with it.
//
// A point that is d > 0 deep is pushed out with k d (1 + d / give): soft enough for the solver at rest, and firm in an
// impact. Friction opposes the velocity u along the ground with at most mu N, N the
// normal force when the step began (lagged, so that friction has a potential of its own); below a creep velocity it grows
// in proportion. Both come from one potential, for a step of length h:
//
//     k d^2 / 2 + k d^3 / (3 give) + h mu N (|u|^2 / (2 creep)  if |u| < creep,  |u| - creep / 2 otherwise)
//
// so Newton's line search holds steps with contact to the same law as all others. [after Li et al. 2020, Incremental Potential
// Contact, with a penalty in place of the barrier: a half-space cannot be passed through, and depth shrinks with the tets]
//
//     loads.contacts.push_back({front.locate(leaf, barycentric), normal, height, stiffness, give, friction, pressing, creep});

#include <algorithm>

#include "engine/base/types.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

struct PointContact {
    Front::Point at;
    Vec3 normal;       // out of the ground, of length 1
    double height;     // [m] of the ground along the normal
    double stiffness;  // [N/m] > 0, k
    double give;       // [m] > 0, depth from which on it gets firm
    double friction;   // Coulomb's coefficient, >= 0
    double pressing;   // [N] normal force that friction is in proportion to, >= 0
    double creep;      // [m/s] > 0

    [[nodiscard]] double depth(const Vec3& x) const { return std::max(0.0, height - normal.dot(x)); }  // [m]
    /// [N] at a depth.
    [[nodiscard]] double push(double d) const { return stiffness * d * (1 + d / give); }
    /// [N/m] its derivative.
    [[nodiscard]] double push_slope(double d) const { return stiffness * (1 + 2 * d / give); }
    [[nodiscard]] Vec3 along(const Vec3& v) const { return v - normal.dot(v) * normal; }

    /// [J] at place x with velocity v, in a step of h [s].
    [[nodiscard]] double potential(const Vec3& x, const Vec3& v, double h) const {
        const double d = depth(x), slip = along(v).norm();
        const double glide = slip < creep ? slip * slip / (2 * creep) : slip - creep / 2;
        return stiffness * d * d * (0.5 + d / (3 * give)) + h * friction * pressing * glide;
    }
    /// [N] minus the derivative of the potential with respect to h v, x = x* + h v.
    [[nodiscard]] Vec3 force(const Vec3& x, const Vec3& v) const {
        const Vec3 slip = along(v);
        return push(depth(x)) * normal - friction * pressing / std::max(slip.norm(), creep) * slip;
    }
    /// [kg] second derivative of the potential with respect to v; positive semidefinite.
    [[nodiscard]] Mat3 tangent(const Vec3& x, const Vec3& v, double h) const {
        const Vec3 slip = along(v);
        const double speed = slip.norm();
        Mat3 flat = Mat3::Identity() - normal * normal.transpose();
        if (speed >= creep) flat -= slip * slip.transpose() / (speed * speed);
        const Mat3 glide = h * friction * pressing / std::max(speed, creep) * flat;
        const double d = depth(x);
        return d > 0 ? Mat3(glide + h * h * push_slope(d) * normal * normal.transpose()) : glide;
    }
};

}  // namespace tetfront
