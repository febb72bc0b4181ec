#pragma once
// The stiffness function: material as a function of rest position, and its mean over a tet.
//
//     StiffnessFunction f({.young = gradient(0, {0, 4}, {1e6, 1e4}, Interpolation::exponential), .poisson =
//     constant(0.3)}); StiffnessFunction layered(layers(2, {0.1, 0.2}), {soft, stiff, soft});    // a MaterialFunction
//     per zone Material m = f.at(x, root); Material leaf = mean_material(f, corners, root);       // integral mean over
//     the tet, not a sample at its centre

#include "engine/material/material.hpp"
#include "engine/material/scalar_function.hpp"
#include "engine/material/zones.hpp"

#include <array>
#include <optional>
#include <vector>

namespace tetfront {

/// A material whose constants may vary with position.
struct MaterialFunction {
    Scalar young = constant(1e5);            // [Pa] > 0; of an isotropic material
    Scalar poisson = constant(0.3);          // (-1, 0.5); of an isotropic material
    Scalar density = constant(1000);         // [kg/m^3] > 0
    Scalar mass_damping = constant(0);       // [1/s] >= 0
    Scalar stiffness_damping = constant(0);  // [s] >= 0
    /// Set: C is that of these constants times `scale`; young and poisson do not matter.
    std::optional<Orthotropic> orthotropic = {};
    Scalar scale = constant(1);  // > 0
};

class StiffnessFunction {
 public:
    explicit StiffnessFunction(MaterialFunction material);
    /// One material per zone. A zone without a material is an InputError when a position in it is asked for.
    StiffnessFunction(Zones zones, std::vector<MaterialFunction> materials);

    /// Throws InputError that names the point when a constant is out of its range there.
    [[nodiscard]] Material at(const Vec3& x, TetId root) const;
    /// True only when at() is one and the same material in the whole box.
    [[nodiscard]] bool constant_within(const Eigen::AlignedBox3d& box, TetId root) const;
    /// False: continuous in space, apart from kinks.
    [[nodiscard]] bool has_jumps() const { return has_jumps_; }
    /// Everything that at() depends on.
    void hash_into(Hash& hash) const;

 private:
    struct Zone {
        MaterialFunction function;
        std::optional<Material> constant;  // set when the function never changes
        std::optional<Sym6> orthotropic;   // of function.orthotropic
    };
    [[nodiscard]] const Zone& zone_at(const Vec3& x, TetId root) const;
    void add_zone(MaterialFunction material);

    Zones where_;  // null: zone 0 everywhere
    std::vector<Zone> zones_;
    bool has_jumps_ = false;
};

/// Integral mean over a tet of elasticity and density; Rayleigh coefficients are weighted by mass and by stiffness.
/// Adaptive: the tet is subdivided until its 4-point rule agrees with that of its children to 1e-4, at most four
/// times (and at least twice where the function has jumps, which a few points may miss); a tet in which the function is
/// constant gets exactly that material.
Material mean_material(const StiffnessFunction& function, const std::array<Vec3, 4>& corners, TetId root);

}  // namespace tetfront
