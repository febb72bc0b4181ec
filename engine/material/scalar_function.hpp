#pragma once
// A scalar of rest position: Young's modulus, density or damping as a constant or a gradient along an axis.
//
//     Scalar young = gradient(2, {0, 0.1}, {1e6, 1e4}, Interpolation::exponential);
//     young->at({0, 0, 0.05}, TetId{});      // 1e5

#include "engine/base/types.hpp"

#include <Eigen/Geometry>
#include <array>
#include <memory>

namespace tetfront {

class ScalarFunction {
 public:
    virtual ~ScalarFunction() = default;
    /// x: rest position [m]. root: the input tet that x is in.
    [[nodiscard]] virtual double at(const Vec3& x, TetId root) const = 0;
    /// True only when at() is one and the same number in the whole box.
    [[nodiscard]] virtual bool constant_within(const Eigen::AlignedBox3d& box, TetId root) const = 0;
    /// False: continuous in space, apart from kinks.
    [[nodiscard]] virtual bool has_jumps() const { return false; }
    /// True when at() never changes.
    [[nodiscard]] virtual bool constant() const { return false; }
};

/// Immutable and shared.
using Scalar = std::shared_ptr<const ScalarFunction>;

Scalar constant(double value);

enum class Interpolation { linear, exponential };

/// values[0] where x[axis] <= at[0], values[1] where x[axis] >= at[1], interpolated between. Throws InputError unless
/// at[0] < at[1] and the values are finite (exponential: above 0).
Scalar gradient(int axis, const std::array<double, 2>& at, const std::array<double, 2>& values,
                Interpolation interpolation);

}  // namespace tetfront
