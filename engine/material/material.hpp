#pragma once
// What an elastic material is at a point: elasticity matrix, density, Rayleigh damping.
//
//     Material rubber{isotropic(1e6, 0.45), 1100};
//     Material wood{orthotropic({.young = {1e9, 5e7, 5e7}, .poisson = {0.3, 0.3, 0.3}, .shear = {2e7, 6e7, 6e7}})};

#include "engine/base/types.hpp"
#include "engine/base/voigt.hpp"

namespace tetfront {

struct Material {
    Sym6 elasticity;               // C [Pa], symmetric positive definite
    double density = 1000;         // [kg/m^3] > 0
    double mass_damping = 0;       // [1/s] Rayleigh, >= 0
    double stiffness_damping = 0;  // [s] Rayleigh, >= 0

    friend bool operator==(const Material&, const Material&) = default;
};

/// Three planes of symmetry. Index pairs of poisson and shear: yz, xz, xy of the material's own axes.
struct Orthotropic {
    Vec3 young = Vec3::Ones();    // [Pa] along the material's axes, > 0
    Vec3 poisson = Vec3::Zero();  // nu_yz, nu_xz, nu_xy: contraction along the second under tension along the first
    Vec3 shear = Vec3::Constant(0.5);  // [Pa] G_yz, G_xz, G_xy, > 0
    Mat3 frame = Mat3::Identity();     // columns: the material's axes, orthonormal and right-handed
};

/// young [Pa] > 0, poisson in (-1, 0.5).
/// Throws InputError for anything else, NaN included.
Sym6 isotropic(double young, double poisson);

/// C of the material rotated into its frame. Throws InputError when a constant is out of range, the frame is no
/// rotation, or the constants together do not give a positive definite matrix.
Sym6 orthotropic(const Orthotropic& constants);

/// Bond's matrix M of a rotation R: stress in the rotated frame is M stress, C' = M C M^T.
Mat6 bond_matrix(const Mat3& rotation);

/// Young's modulus of the isotropic material that is nearest to C (Voigt's average over all orientations): for display
/// only. Exact for an isotropic C.
double representative_young(const Sym6& elasticity);

}  // namespace tetfront
