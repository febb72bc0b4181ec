#include "tests/benchmarks/scalar_explicit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace tetfront {

namespace {
const Vec3 gravity(0, 0, -9.81);
}

ScalarExplicit::ScalarExplicit(std::vector<Vec3> rest, std::vector<std::array<int, 4>> tets, std::vector<char> pinned, const Material& material)
    : lambda_(material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson))),
      mu_(material.young / (2 * (1 + material.poisson))),
      tets_(std::move(tets)),
      pinned_(std::move(pinned)),
      inverse_rest_(tets_.size()),
      volume_(tets_.size()),
      mass_(rest.size(), 0),
      x_(std::move(rest)),
      v_(x_.size(), Vec3::Zero()),
      f_(x_.size(), Vec3::Zero()) {
    double steepest = 0;
    for (std::size_t t = 0; t < tets_.size(); ++t) {
        const auto& n = tets_[t];
        const auto at = [&](std::size_t i) { return x_[static_cast<std::size_t>(n[i])]; };
        Mat3 edges;
        edges << at(1) - at(0), at(2) - at(0), at(3) - at(0);
        inverse_rest_[t] = edges.inverse();
        volume_[t] = edges.determinant() / 6;
        for (int i : n) mass_[static_cast<std::size_t>(i)] += material.density * volume_[t] / 4;
        const Vec3 first = -inverse_rest_[t].colwise().sum();
        steepest = std::max(steepest, inverse_rest_[t].squaredNorm() + first.squaredNorm());
    }
    stable_step_ = 0.9 * 2 / std::sqrt(4 * (lambda_ + 2 * mu_) / material.density * steepest);
}

void ScalarExplicit::forces() {
    std::fill(f_.begin(), f_.end(), Vec3(Vec3::Zero()));
    for (std::size_t t = 0; t < tets_.size(); ++t) {
        const auto n0 = static_cast<std::size_t>(tets_[t][0]), n1 = static_cast<std::size_t>(tets_[t][1]);
        const auto n2 = static_cast<std::size_t>(tets_[t][2]), n3 = static_cast<std::size_t>(tets_[t][3]);
        Mat3 edges;
        edges << x_[n1] - x_[n0], x_[n2] - x_[n0], x_[n3] - x_[n0];
        const Mat3 f = edges * inverse_rest_[t];
        const Mat3 strain = 0.5 * (f.transpose() * f - Mat3::Identity());
        const Mat3 stress = lambda_ * strain.trace() * Mat3::Identity() + 2 * mu_ * strain;
        const Mat3 h = -volume_[t] * (f * stress) * inverse_rest_[t].transpose();
        f_[n1] += h.col(0);
        f_[n2] += h.col(1);
        f_[n3] += h.col(2);
        f_[n0] -= h.col(0) + h.col(1) + h.col(2);
    }
}

void ScalarExplicit::step(double seconds) {
    forces();
    for (std::size_t i = 0; i < x_.size(); ++i) {
        if (pinned_[i]) continue;
        v_[i] += seconds * (f_[i] / mass_[i] + gravity);
        x_[i] += seconds * v_[i];
    }
}

int ScalarExplicit::substeps(double seconds) const { return std::max(1, static_cast<int>(std::ceil(seconds / stable_step_))); }

void ScalarExplicit::frame(double seconds) {
    const int n = substeps(seconds);
    for (int i = 0; i < n; ++i) step(seconds / n);
}

}  // namespace tetfront
