#include "engine/mechanics/cell_sampling.hpp"

#include "engine/base/error.hpp"
#include "engine/mechanics/cell_fit.hpp"
#include "engine/mechanics/cell_samples.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tetfront {

namespace {

/// Deformation gradient of the parent whose Green strain is alpha along Voigt component m. 1 + 2 E must be positive.
Mat3 stretch(int m, double alpha) {
    const Mat3 e = strain_tensor(alpha * Vec6::Unit(m));
    return Eigen::SelfAdjointEigenSolver<Mat3>(Mat3(Mat3::Identity() + 2 * e)).operatorSqrt();
}

/// One parent with its children, in units in which the mean stiffness and the largest mode gradient are about 1.
template <int Modes>
class Cell {
 public:
    static constexpr int n = 3 * Modes;
    using Vector = Eigen::Matrix<double, n, 1>;
    using Matrix = Eigen::Matrix<double, n, n>;

    Cell(const ModeTable<Modes>& modes, const Eigen::Matrix<double, 3, 4>& gradients,
         const std::array<Sym6, 8>& children, double stiffness) {
        const double size = 1 / gradients.norm();
        for (std::size_t k = 0; k < 8; ++k) {
            c_[k] = children[k].matrix() / stiffness;
            g_[k] = size * gradients * modes[k];
        }
    }

    struct State {
        double energy = 0;
        Vector gradient = Vector::Zero();
        bool inverted = false;
        std::array<Mat3, 8> f;       // of the children
        std::array<Vec6, 8> strain;  // Green
        std::array<Vec6, 8> stress;  // second Piola-Kirchhoff
    };

    void evaluate(const Mat3& f, const Vector& q, State& s) const {
        const Eigen::Map<const Eigen::Matrix<double, 3, Modes>> modes(q.data());
        Eigen::Matrix<double, 3, Modes> gradient = Eigen::Matrix<double, 3, Modes>::Zero();
        s.energy = 0;
        s.inverted = false;
        for (std::size_t k = 0; k < 8; ++k) {
            s.f[k].noalias() = f + modes * g_[k].transpose();
            s.inverted = s.inverted || !(s.f[k].determinant() > 0);
            Mat3 e;
            e.noalias() = 0.5 * (s.f[k].transpose() * s.f[k] - Mat3::Identity());
            s.strain[k] = voigt_strain(e);
            s.stress[k].noalias() = c_[k] * s.strain[k];
            s.energy += 0.5 * s.stress[k].dot(s.strain[k]);
            gradient.noalias() += (s.f[k] * stress_tensor(s.stress[k])) * g_[k];
        }
        s.gradient = Eigen::Map<const Vector>(gradient.data());
    }

    /// Second derivative of the energy; without its geometric part it is positive definite.
    [[nodiscard]] Matrix hessian(const State& s, bool geometric) const {
        Matrix h = Matrix::Zero();
        Eigen::Matrix<double, 6, n> b;
        for (std::size_t k = 0; k < 8; ++k) {
            const Mat3& f = s.f[k];
            for (int p = 0; p < Modes; ++p) {
                const Vec3 g = g_[k].col(p);
                for (int row = 0; row < 3; ++row) b.template block<1, 3>(row, 3 * p) = g[row] * f.col(row).transpose();
                b.template block<1, 3>(3, 3 * p) = (g[2] * f.col(1) + g[1] * f.col(2)).transpose();
                b.template block<1, 3>(4, 3 * p) = (g[2] * f.col(0) + g[0] * f.col(2)).transpose();
                b.template block<1, 3>(5, 3 * p) = (g[1] * f.col(0) + g[0] * f.col(1)).transpose();
            }
            Eigen::Matrix<double, 6, n> cb;
            cb.noalias() = c_[k] * b;
            h.noalias() += b.transpose() * cb;
            if (geometric) {
                const Eigen::Matrix<double, Modes, Modes> w = g_[k].transpose() * stress_tensor(s.stress[k]) * g_[k];
                for (int p = 0; p < Modes; ++p)
                    for (int r = 0; r < Modes; ++r) h.template block<3, 3>(3 * p, 3 * r).diagonal().array() += w(p, r);
            }
        }
        return h;
    }

    /// Second Piola-Kirchhoff stress of the parent.
    [[nodiscard]] Vec6 mean_stress(const Mat3& f, const State& s) const {
        Mat3 p = Mat3::Zero();
        for (std::size_t k = 0; k < 8; ++k) p.noalias() += s.f[k] * stress_tensor(s.stress[k]);
        const Mat3 mean = f.inverse() * p / 8;
        return voigt_stress(0.5 * (mean + mean.transpose()));
    }

    /// Minimises the energy from q. tolerance: of the gradient's largest entry. Returns false when it does not converge
    /// or a child is inside out. factor: a factorised Hessian to begin with; the last one used at the end.
    bool relax(const Mat3& f, Vector& q, State& s, Eigen::LLT<Matrix>& factor, double tolerance,
               int& iterations) const {
        evaluate(f, q, s);
        if (s.inverted) {
            q.setZero();
            evaluate(f, q, s);
        }
        bool fresh = false;
        for (int iteration = 0; iteration < 60; ++iteration) {
            const double residual = s.gradient.cwiseAbs().maxCoeff();
            if (!(residual < std::numeric_limits<double>::infinity())) return false;
            if (residual <= tolerance) return true;
            ++iterations;
            const Vector step = -factor.solve(s.gradient);
            const double slope = step.dot(s.gradient);
            State next;
            Vector moved = q;
            double t = slope < 0 ? 1 : 0;
            for (; t > 1e-4; t /= 2) {
                moved = q + t * step;
                evaluate(f, moved, next);
                if (!next.inverted && next.energy <= s.energy + 1e-4 * t * slope + 1e-12 * s.energy) break;
            }
            const bool moves = t > 1e-4;
            const bool fast = moves && next.gradient.cwiseAbs().maxCoeff() < 0.15 * residual;
            if (moves) {
                q = moved;
                s = next;
            } else if (fresh) {
                return false;
            }
            fresh = false;
            if (!fast) {
                factor.compute(hessian(s, true));
                if (factor.info() != Eigen::Success) factor.compute(hessian(s, false));
                if (factor.info() != Eigen::Success) return false;
                fresh = true;
            }
        }
        return false;
    }

 private:
    std::array<Mat6, 8> c_;
    std::array<Eigen::Matrix<double, 3, Modes>, 8> g_;
};

struct Sample {
    double alpha = 0;
    Vec6 stress = Vec6::Zero();
    double child_reach = 0;  // largest strain component of a child over its valid range; above 1 it is outside
};

double reach(const std::array<Vec6, 8>& strain, const std::array<StrainRange, 8>& ranges) {
    double largest = 0;
    for (std::size_t k = 0; k < 8; ++k)
        for (std::size_t m = 0; m < 6; ++m) {
            const double e = strain[k][static_cast<int>(m)];
            largest = std::max(largest, e / ranges[k][m][e < 0 ? 0 : 1]);
        }
    return largest;
}

using LinearLaws = std::array<std::array<LinearLaw, 6>, 6>;  // of stress j under strain m

/// Largest deviation of a sample from column m of c over what is allowed, all six stress components.
double deviation(const Mat6& c, int m, const Sample& sample, const LinearLaws& laws) {
    double largest = sample.child_reach;
    for (int j = 0; j < 6; ++j) {
        const LinearLaw& law = laws[static_cast<std::size_t>(j)][static_cast<std::size_t>(m)];
        largest = std::max(largest, law.deviation(sample.alpha, c(j, m), sample.stress[j]));
    }
    return largest;
}

/// How far the line holds along samples of growing |alpha|: where the deviation, interpolated, reaches 1; the last
/// sample when it never does.
double valid_end(const Mat6& c, int m, const std::vector<Sample>& side, const LinearLaws& laws) {
    double alpha = 0, before = 0;
    for (const Sample& sample : side) {
        const double now = deviation(c, m, sample, laws);
        if (!(now < 1)) return alpha + (sample.alpha - alpha) * (1 - before) / (now - before);
        alpha = sample.alpha;
        before = now;
    }
    return alpha;
}

/// Mean of the children's diagonal entries: the unit of stress that cells compute in.
double unit_stress(const std::array<Sym6, 8>& children) {
    double stiffness = 0;
    for (const Sym6& c : children) stiffness += c.matrix().trace() / 48;
    return stiffness;
}

template <int Modes>
SampledCell sample(const ModeTable<Modes>& modes, const Sym6& tangent_matrix,
                   const Eigen::Matrix<double, 3, 4>& gradients, const std::array<Sym6, 8>& children,
                   const std::array<StrainRange, 8>* child_ranges, const SamplingSettings& settings) {
    using C = Cell<Modes>;
    const double stiffness = unit_stress(children);
    const C cell(modes, gradients, children, stiffness);
    const Mat6 tangent = tangent_matrix.matrix() / stiffness;
    // T2 of each pair in units of its own stiffnesses: one number for all would swallow the shear of nearly
    // incompressible material, whose bulk stiffness is many times larger.
    LinearLaws laws;
    for (int j = 0; j < 6; ++j)
        for (int k = 0; k < 6; ++k)
            laws[static_cast<std::size_t>(j)][static_cast<std::size_t>(k)] = {
                settings.relative_tolerance, settings.stress_tolerance * std::sqrt(tangent(j, j) * tangent(k, k))};

    typename C::State rest;
    cell.evaluate(Mat3::Identity(), C::Vector::Zero(), rest);
    const Eigen::LLT<typename C::Matrix> rest_factor(cell.hessian(rest, false));
    ENSURE(rest_factor.info() == Eigen::Success, "cell problem is not positive definite");

    SampledCell result;
    std::array<std::array<std::vector<Sample>, 2>, 6> samples;
    for (int m = 0; m < 6; ++m) {
        // q = alpha times this, to first order: the relaxation of the small strain e_m.
        typename C::State unit;
        cell.evaluate(stretch(m, 1e-6), C::Vector::Zero(), unit);
        const typename C::Vector first = -rest_factor.solve(unit.gradient) / 1e-6;
        for (std::size_t side = 0; side < 2; ++side) {
            auto& list = samples[static_cast<std::size_t>(m)][side];
            typename C::Vector slope_before = first;  // q / alpha of the sample before
            double alpha_before = 0;
            auto factor = rest_factor;
            for (const double magnitude : settings.alphas) {
                const double alpha = side == 0 ? -magnitude : magnitude;
                // q / alpha is nearly linear in alpha.
                const double growth = alpha_before == 0 ? 0 : alpha / alpha_before;
                typename C::Vector q = alpha * (first + growth * (slope_before - first));
                typename C::State state;
                const Mat3 f = stretch(m, alpha);
                const double tolerance = std::max(1e-6 * tangent(m, m) * magnitude, 1e-14);
                if (!cell.relax(f, q, state, factor, tolerance, result.newton_iterations)) break;
                list.push_back(
                    {alpha, cell.mean_stress(f, state), child_ranges ? reach(state.strain, *child_ranges) : 0});
                ++result.samples;
                slope_before = q / alpha;
                alpha_before = alpha;
                // Far off the tangent: farther samples could only be outliers of the fit.
                if (deviation(tangent, m, list.back(), laws) > 4) break;
            }
        }
    }

    Mat6 fitted = tangent;
    std::vector<double> alphas, stresses;
    for (int m = 0; m < 6; ++m) {
        const auto& sides = samples[static_cast<std::size_t>(m)];
        for (int j = 0; j < 6; ++j) {
            alphas.clear();
            stresses.clear();
            for (const auto& side : sides)
                for (const Sample& s : side) {
                    alphas.push_back(s.alpha);
                    stresses.push_back(s.stress[j]);
                }
            if (!alphas.empty()) fitted(j, m) = fit_slope(alphas, stresses, laws[static_cast<std::size_t>(j)][static_cast<std::size_t>(m)]);
        }
    }
    fitted = (0.5 * (fitted + fitted.transpose())).eval();
    if (Eigen::LLT<Mat6>(fitted).info() != Eigen::Success) {
        fitted = tangent;
        result.fitted = false;
    }
    result.residual = (fitted - tangent).cwiseAbs().maxCoeff() / tangent.norm();
    for (std::size_t m = 0; m < 6; ++m)
        for (std::size_t side = 0; side < 2; ++side)
            result.valid_range[m][side] = valid_end(fitted, static_cast<int>(m), samples[m][side], laws);
    result.elasticity = Sym6::from(stiffness * fitted);
    return result;
}

template <int Modes>
std::vector<CellSample> curve(const ModeTable<Modes>& modes, const Eigen::Matrix<double, 3, 4>& gradients,
                              const std::array<Sym6, 8>& children, int m, std::span<const double> alphas) {
    using C = Cell<Modes>;
    const double stiffness = unit_stress(children);
    const C cell(modes, gradients, children, stiffness);
    typename C::State state;
    cell.evaluate(Mat3::Identity(), C::Vector::Zero(), state);
    const Eigen::LLT<typename C::Matrix> rest_factor(cell.hessian(state, false));
    ENSURE(rest_factor.info() == Eigen::Success, "cell problem is not positive definite");
    std::vector<CellSample> samples;
    int iterations = 0;
    for (const double alpha : alphas) {
        ENSURE(alpha != 0 && std::abs(alpha) < 0.49, "alpha ", alpha);
        auto factor = rest_factor;
        typename C::Vector q = C::Vector::Zero();
        const Mat3 f = stretch(m, alpha);
        if (cell.relax(f, q, state, factor, std::max(1e-7 * std::abs(alpha), 1e-14), iterations))
            samples.push_back({alpha, stiffness * cell.mean_stress(f, state)});
    }
    return samples;
}

}  // namespace

std::vector<CellSample> sample_curve(CellProblem problem, const Eigen::Matrix<double, 3, 4>& gradients,
                                     const std::array<Sym6, 8>& children, int m, std::span<const double> alphas) {
    switch (problem) {
        case CellProblem::mean_strain:
            return curve(mean_strain_modes(), gradients, children, m, alphas);
        case CellProblem::isolated:
            return curve(isolated_modes(), gradients, children, m, alphas);
        case CellProblem::uniform_stress:
            return curve(uniform_stress_modes(), gradients, children, m, alphas);
        case CellProblem::average:
            break;
    }
    ENSURE(false, "average needs no samples");
}

SampledCell sample_cell(CellProblem problem, const Eigen::Matrix<double, 3, 4>& gradients,
                        const std::array<Sym6, 8>& children, const std::array<StrainRange, 8>* child_ranges,
                        const SamplingSettings& settings) {
    const Sym6 tangent = solve_cell(problem, gradients, children);
    switch (problem) {
        case CellProblem::mean_strain:
            return sample(mean_strain_modes(), tangent, gradients, children, child_ranges, settings);
        case CellProblem::isolated:
            return sample(isolated_modes(), tangent, gradients, children, child_ranges, settings);
        case CellProblem::uniform_stress:
            return sample(uniform_stress_modes(), tangent, gradients, children, child_ranges, settings);
        case CellProblem::average:
            break;
    }
    // Every child has the parent's strain: S = <C_c> E holds without an end.
    SampledCell result;
    result.elasticity = tangent;
    result.valid_range = unbounded_range;
    if (child_ranges) {
        for (const StrainRange& range : *child_ranges)
            for (std::size_t m = 0; m < 6; ++m) {
                result.valid_range[m][0] = std::max(result.valid_range[m][0], range[m][0]);
                result.valid_range[m][1] = std::min(result.valid_range[m][1], range[m][1]);
            }
    }
    return result;
}

}  // namespace tetfront
