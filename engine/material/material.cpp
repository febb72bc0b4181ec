#include "engine/material/material.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <string>

namespace tetfront {

namespace {

void require(bool holds, const char* where, double value, const char* allowed) {
    if (!holds) throw InputError("", where, "is " + std::to_string(value), allowed);
}

}  // namespace

Sym6 isotropic(double young, double poisson) {
    require(young > 0 && std::isfinite(young), "young", young, "use a finite number above 0");
    require(poisson > -1 && poisson < 0.5, "poisson", poisson, "use a number above -1 and below 0.5");
    return Sym6::from(isotropic_elasticity(young, poisson));
}

Sym6 orthotropic(const Orthotropic& m) {
    static constexpr const char* pair_names[] = {"yz", "xz", "xy"};
    static constexpr const char* axis_names[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
        require(m.young[i] > 0 && std::isfinite(m.young[i]), (std::string("young/") + axis_names[i]).c_str(),
                m.young[i], "use a finite number above 0");
        require(m.shear[i] > 0 && std::isfinite(m.shear[i]), (std::string("shear/") + pair_names[i]).c_str(),
                m.shear[i], "use a finite number above 0");
        require(std::isfinite(m.poisson[i]), (std::string("poisson/") + pair_names[i]).c_str(), m.poisson[i],
                "use a finite number");
    }
    const double off = (m.frame.transpose() * m.frame - Mat3::Identity()).cwiseAbs().maxCoeff();
    if (!(off < 1e-6) || m.frame.determinant() < 0) {
        throw InputError("", "frame", "is not a rotation", "use orthonormal, right-handed axes");
    }
    Mat6 compliance = Mat6::Zero();
    for (int i = 0; i < 3; ++i) compliance(i, i) = 1 / m.young[i];
    for (int k = 0; k < 3; ++k) {
        const auto [i, j] = voigt_pairs[static_cast<std::size_t>(3 + k)];
        compliance(i, j) = compliance(j, i) = -m.poisson[k] / m.young[i];
        compliance(3 + k, 3 + k) = 1 / m.shear[k];
    }
    const Eigen::LLT<Mat6> cholesky(compliance);
    // Scaled to ones on the diagonal, so that it is not the contrast of the axes that counts.
    const Vec6 scale = compliance.diagonal().cwiseSqrt().cwiseInverse();
    const double least = Eigen::SelfAdjointEigenSolver<Mat6>(scale.asDiagonal() * compliance * scale.asDiagonal(),
                                                             Eigen::EigenvaluesOnly)
                             .eigenvalues()[0];
    if (cholesky.info() != Eigen::Success || !(least > 1e-6)) {
        throw InputError("", "poisson", "together with young gives a matrix that is not positive definite",
                         "use smaller Poisson's ratios");
    }
    const Mat6 bond = bond_matrix(m.frame);
    return Sym6::from(bond * cholesky.solve(Mat6::Identity()) * bond.transpose());
}

Mat6 bond_matrix(const Mat3& r) {
    // Column m: the stress R s R^T of the unit stress s in component m.
    Mat6 bond;
    for (int m = 0; m < 6; ++m) bond.col(m) = voigt_stress(r * stress_tensor(Vec6::Unit(m)) * r.transpose());
    return bond;
}

double representative_young(const Sym6& c) {
    // Voigt's invariants: 9 K = sum of the normal block, 30 mu = 2 (diagonal - off-diagonal) + 6 shear.
    const double diagonal = c(0, 0) + c(1, 1) + c(2, 2), off = c(0, 1) + c(0, 2) + c(1, 2);
    const double bulk = (diagonal + 2 * off) / 9, shear = (diagonal - off + 3 * (c(3, 3) + c(4, 4) + c(5, 5))) / 15;
    return 9 * bulk * shear / (3 * bulk + shear);
}

}  // namespace tetfront
