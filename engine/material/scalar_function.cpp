#include "engine/material/scalar_function.hpp"

#include "engine/base/error.hpp"

#include <cmath>
#include <string>

namespace tetfront {

namespace {

class Constant : public ScalarFunction {
 public:
    explicit Constant(double value) : value_(value) {}
    double at(const Vec3&, TetId) const override { return value_; }
    bool constant_within(const Eigen::AlignedBox3d&, TetId) const override { return true; }
    bool constant() const override { return true; }

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
                                                       : values_[0] * std::pow(values_[1] / values_[0], s);
    }
    bool constant_within(const Eigen::AlignedBox3d& box, TetId) const override {
        return constant() || box.max()[axis_] <= at_[0] || box.min()[axis_] >= at_[1];
    }
    bool constant() const override { return values_[0] == values_[1]; }

 private:
    int axis_;
    std::array<double, 2> at_, values_;
    Interpolation interpolation_;
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

}  // namespace tetfront
