#include "engine/mechanics/pcg.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "engine/base/parallel.hpp"

namespace tetfront {

namespace {
constexpr std::size_t grain = 2048;

double dot(const DofVector& a, const DofVector& b) {
    return parallel_sum(a.size(), grain, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += a[i].dot(b[i]);
        return sum;
    });
}
}  // namespace

void BlockJacobi::build(const BlockMatrix& matrix) {
    inverse_.resize(matrix.size());
    parallel_for(matrix.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) inverse_[i] = matrix.diagonal_block(i).inverse();
    });
}

void BlockJacobi::apply(const DofVector& r, DofVector& z) const {
    parallel_for(r.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) z[i] = inverse_[i] * r[i];
    });
}

PcgResult Pcg::solve(const BlockMatrix& a, const Preconditioner& preconditioner, const DofVector& b, DofVector& x,
                     const PcgLimits& limits) {
    const std::size_t n = b.size();
    for (DofVector* v : {&r_, &z_, &p_, &q_}) v->resize(n);
    PcgResult result;
    preconditioner.apply(b, z_);
    const double scale = dot(b, z_);  // b^T B b
    if (!(scale > 0)) {               // b = 0 (or not finite: then say so)
        x.assign(n, Vec3::Zero());
        result.converged = scale == 0;
        return result;
    }
    a.multiply(x, q_);
    for (std::size_t i = 0; i < n; ++i) r_[i] = b[i] - q_[i];
    preconditioner.apply(r_, z_);
    p_ = z_;
    double rz = dot(r_, z_);
    const double goal = limits.tolerance * limits.tolerance * scale;
    while (rz > goal && result.iterations < limits.iterations) {
        a.multiply(p_, q_);
        const double curvature = dot(p_, q_);
        if (!(curvature > 0)) break;  // not positive definite to rounding, or not finite
        const double alpha = rz / curvature;
        parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                x[i] += alpha * p_[i];
                r_[i] -= alpha * q_[i];
            }
        });
        preconditioner.apply(r_, z_);
        const double next = dot(r_, z_);
        const double beta = next / rz;
        rz = next;
        parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) p_[i] = z_[i] + beta * p_[i];
        });
        ++result.iterations;
    }
    result.residual = std::sqrt(rz / scale);
    result.converged = rz <= goal;
    return result;
}

}  // namespace tetfront
