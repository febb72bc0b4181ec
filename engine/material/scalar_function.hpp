#pragma once
// A scalar of rest position: Young's modulus, Poisson's ratio, density or damping.
//
//     Scalar young = gradient(2, {0, 0.1}, {1e6, 1e4}, Interpolation::exponential);
//     young->at({0, 0, 0.05}, TetId{});                        // 1e5
//     Scalar measured = voxel_scalar(image, VoxelSampling::linear, 1000);   // 1000 Pa per unit of the image
//     Scalar by_tet = per_root({1e5, 2e5, ...});                // one value per input tet

#include "engine/base/hash.hpp"
#include "engine/base/types.hpp"
#include "engine/material/voxel_image.hpp"

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace tetfront {

class ScalarFunction {
 public:
    virtual ~ScalarFunction() = default;
    /// x: rest position [m]. root: the input tet that x is in.
    [[nodiscard]] virtual double at(const Vec3& x, TetId root) const = 0;
    /// True only when at() is one and the same number in the whole box.
    [[nodiscard]] virtual bool constant_within(const Eigen::AlignedBox3d& box, TetId root) const = 0;
    /// False: continuous in space and smooth on the scale of a tet, apart from kinks.
    [[nodiscard]] virtual bool has_jumps() const { return false; }
    /// True when at() never changes.
    [[nodiscard]] virtual bool constant() const { return false; }
    /// What gave the value at x, for messages ("e.nrrd, voxel (1, 2, 3)"); empty: nothing worth a name.
    [[nodiscard]] virtual std::string source(const Vec3& x) const {
        static_cast<void>(x);
        return "";
    }
    /// Everything that at() depends on.
    virtual void hash_into(Hash& hash) const = 0;
};

/// Immutable and shared.
using Scalar = std::shared_ptr<const ScalarFunction>;

Scalar constant(double value);

enum class Interpolation { linear, exponential };

/// values[0] where x[axis] <= at[0], values[1] where x[axis] >= at[1], interpolated between. Throws InputError unless
/// at[0] < at[1] and the values are finite (exponential: above 0).
Scalar gradient(int axis, const std::array<double, 2>& at, const std::array<double, 2>& values,
                Interpolation interpolation);

/// One value per input tet. Asking for a root outside of [0, values.size()) is an InputError.
Scalar per_root(std::vector<double> values);

enum class VoxelSampling { nearest, linear };

/// factor times the image's value at x; positions outside of the image take its border. Throws InputError that names
/// the first voxel that is not a finite number, or below `least`.
Scalar voxel_scalar(std::shared_ptr<const VoxelImage> image, VoxelSampling sampling, double factor = 1,
                    double least = -std::numeric_limits<double>::infinity());

}  // namespace tetfront
