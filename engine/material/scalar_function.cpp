#include "engine/material/scalar_function.hpp"

#include "engine/base/error.hpp"

#include <cmath>
#include <string>
#include <utility>

namespace tetfront {

namespace {

class Constant : public ScalarFunction {
 public:
    explicit Constant(double value) : value_(value) {}
    double at(const Vec3&, TetId) const override { return value_; }
    bool constant_within(const Eigen::AlignedBox3d&, TetId) const override { return true; }
    bool constant() const override { return true; }
    void hash_into(Hash& hash) const override { hash.add("constant").add(value_); }

 private:
    double value_;
};

class Gradient : public ScalarFunction {
 public:
    Gradient(int axis, const std::array<double, 2>& at, const std::array<double, 2>& values,
             Interpolation interpolation)
        : axis_(axis), at_(at), values_(values), interpolation_(interpolation) {}

    double at(const Vec3& x, TetId) const override {
        if (x[axis_] <= at_[0]) return values_[0];
        if (x[axis_] >= at_[1]) return values_[1];
        const double s = (x[axis_] - at_[0]) / (at_[1] - at_[0]);
        return interpolation_ == Interpolation::linear ? values_[0] + s * (values_[1] - values_[0])
                                                       : std::exp((1 - s) * std::log(values_[0]) + s * std::log(values_[1]));
    }
    bool constant_within(const Eigen::AlignedBox3d& box, TetId) const override {
        return constant() || box.max()[axis_] <= at_[0] || box.min()[axis_] >= at_[1];
    }
    bool constant() const override { return values_[0] == values_[1]; }
    void hash_into(Hash& hash) const override {
        hash.add("gradient").add(axis_).add_range(at_).add_range(values_).add(interpolation_);
    }

 private:
    int axis_;
    std::array<double, 2> at_, values_;
    Interpolation interpolation_;
};

class PerRoot : public ScalarFunction {
 public:
    explicit PerRoot(std::vector<double> values) : values_(std::move(values)) {}
    double at(const Vec3&, TetId root) const override {
        if (!root.valid() || root.index() >= values_.size()) {
            throw InputError("", "tet " + std::to_string(root.value),
                             "has no value among the " + std::to_string(values_.size()) + " given",
                             "give one value for each tet of the input mesh");
        }
        return values_[root.index()];
    }
    bool constant_within(const Eigen::AlignedBox3d&, TetId) const override { return true; }
    bool has_jumps() const override { return true; }
    void hash_into(Hash& hash) const override { hash.add("per root").add_range(values_); }

 private:
    std::vector<double> values_;
};

class VoxelScalar : public ScalarFunction {
 public:
    VoxelScalar(std::shared_ptr<const VoxelImage> image, VoxelSampling sampling, double factor)
        : image_(std::move(image)), sampling_(sampling), factor_(factor) {}

    double at(const Vec3& x, TetId) const override {
        const Vec3 p = image_->continuous_index(x);
        if (sampling_ == VoxelSampling::nearest) return factor_ * image_->at(image_->nearest(p));
        std::array<int, 3> low{};
        Vec3 s;
        for (int axis = 0; axis < 3; ++axis) {
            const int last = image_->size[static_cast<std::size_t>(axis)] - 1;
            const double clamped = std::clamp(p[axis], 0.0, static_cast<double>(last));
            low[static_cast<std::size_t>(axis)] = std::min(static_cast<int>(clamped), std::max(last - 1, 0));
            s[axis] = clamped - low[static_cast<std::size_t>(axis)];
        }
        double sum = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            std::array<int, 3> voxel = low;
            double weight = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const bool upper = (corner >> axis) & 1U;
                weight *= upper ? s[static_cast<int>(axis)] : 1 - s[static_cast<int>(axis)];
                if (upper) voxel[axis] = std::min(voxel[axis] + 1, image_->size[axis] - 1);
            }
            if (weight > 0) sum += weight * image_->at(voxel);
        }
        return factor_ * sum;
    }
    bool constant_within(const Eigen::AlignedBox3d& box, TetId) const override {
        return image_->one_value_within(box, sampling_ == VoxelSampling::linear ? 1 : 0);
    }
    bool has_jumps() const override { return true; }
    std::string source(const Vec3& x) const override {
        return image_->source + ", " + image_->describe(image_->nearest(image_->continuous_index(x)));
    }
    void hash_into(Hash& hash) const override {
        hash.add("voxels").add(sampling_).add(factor_);
        image_->hash_into(hash);
    }

 private:
    std::shared_ptr<const VoxelImage> image_;
    VoxelSampling sampling_;
    double factor_;
};

}  // namespace

Scalar constant(double value) { return std::make_shared<Constant>(value); }

Scalar gradient(int axis, const std::array<double, 2>& at, const std::array<double, 2>& values,
                Interpolation interpolation) {
    ENSURE(axis >= 0 && axis < 3, "axis ", axis);
    if (!(at[0] < at[1]) || !std::isfinite(at[1] - at[0])) {
        throw InputError("", "at", "goes from " + std::to_string(at[0]) + " to " + std::to_string(at[1]),
                         "give two finite coordinates in ascending order");
    }
    for (std::size_t i = 0; i < 2; ++i) {
        if (!std::isfinite(values[i]) || (interpolation == Interpolation::exponential && !(values[i] > 0))) {
            throw InputError(
                "", "values/" + std::to_string(i), "is " + std::to_string(values[i]),
                interpolation == Interpolation::linear ? "use a finite number" : "use a finite number above 0");
        }
    }
    return std::make_shared<Gradient>(axis, at, values, interpolation);
}

Scalar per_root(std::vector<double> values) { return std::make_shared<PerRoot>(std::move(values)); }

Scalar voxel_scalar(std::shared_ptr<const VoxelImage> image, VoxelSampling sampling, double factor, double least) {
    for (int k = 0; k < image->size[2]; ++k)
        for (int j = 0; j < image->size[1]; ++j)
            for (int i = 0; i < image->size[0]; ++i)
                if (const double value = image->at({i, j, k}); !std::isfinite(value) || value < least) {
                    const std::string problem =
                        std::isfinite(value) ? "is " + std::to_string(value) : "is not a finite number";
                    throw InputError(image->source, image->describe({i, j, k}), problem,
                                     least == 0 ? "fill every voxel with a finite number, 0 or above"
                                                : "fill every voxel with a finite number");
                }
    return std::make_shared<VoxelScalar>(std::move(image), sampling, factor);
}

}  // namespace tetfront
