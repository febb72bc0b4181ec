#include "engine/material/stiffness.hpp"

#include "engine/base/error.hpp"

#include <cmath>
#include <sstream>
#include <utility>

namespace tetfront {

namespace {

void require(bool holds, const char* what, double value, const Vec3& x, const char* allowed) {
    if (holds) return;
    std::ostringstream where, problem;
    where << what << " at (" << x.transpose() << ')';
    problem << "is " << value;
    throw InputError("", where.str(), problem.str(), allowed);
}

Material evaluate(const MaterialFunction& f, const Vec3& x, TetId root) {
    const double young = f.young->at(x, root), poisson = f.poisson->at(x, root), density = f.density->at(x, root);
    const double mass_damping = f.mass_damping->at(x, root), stiffness_damping = f.stiffness_damping->at(x, root);
    require(young > 0 && std::isfinite(young), "Young's modulus", young, x, "must be finite and above 0");
    require(poisson > -1 && poisson < 0.5, "Poisson's ratio", poisson, x, "must be above -1 and below 0.5");
    require(density > 0 && std::isfinite(density), "density", density, x, "must be finite and above 0");
    require(mass_damping >= 0 && std::isfinite(mass_damping), "mass damping", mass_damping, x, "must be at least 0");
    require(stiffness_damping >= 0 && std::isfinite(stiffness_damping), "stiffness damping", stiffness_damping, x,
            "must be at least 0");
    return {Sym6::from(isotropic_elasticity(young, poisson)), density, mass_damping, stiffness_damping};
}

/// Sums of what mean_material averages.
struct Integral {
    Sym6 elasticity;
    double density = 0, mass_damping = 0, stiffness_damping = 0;

    void add(const Integral& other, double weight) {
        for (std::size_t i = 0; i < 21; ++i) elasticity.upper[i] += weight * other.elasticity.upper[i];
        density += weight * other.density;
        mass_damping += weight * other.mass_damping;
        stiffness_damping += weight * other.stiffness_damping;
    }
};

double stiffness_of(const Sym6& c) { return c(0, 0) + c(1, 1) + c(2, 2) + 2 * (c(3, 3) + c(4, 4) + c(5, 5)); }

Integral integrand(const Material& m) {
    return {m.elasticity, m.density, m.density * m.mass_damping, stiffness_of(m.elasticity) * m.stiffness_damping};
}

Material mean_of(const Integral& i) {
    return {i.elasticity, i.density, i.mass_damping / i.density, i.stiffness_damping / stiffness_of(i.elasticity)};
}

/// Both means to 1e-4 of each other.
bool agree(const Integral& a, const Integral& b) {
    constexpr double tolerance = 1e-4;
    const double scale = stiffness_of(b.elasticity);
    for (std::size_t i = 0; i < 21; ++i)
        if (std::abs(a.elasticity.upper[i] - b.elasticity.upper[i]) > tolerance * scale) return false;
    return std::abs(a.density - b.density) <= tolerance * b.density &&
           std::abs(a.mass_damping - b.mass_damping) <= tolerance * b.mass_damping &&
           std::abs(a.stiffness_damping - b.stiffness_damping) <= tolerance * b.stiffness_damping;
}

using Corners = std::array<Vec3, 4>;

/// Degree 2 rule on four points.
Integral four_points(const StiffnessFunction& f, const Corners& x, TetId root) {
    constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;
    const Vec3 sum = x[0] + x[1] + x[2] + x[3];
    Integral integral;
    for (const Vec3& corner : x) integral.add(integrand(f.at(far * sum + (near - far) * corner, root)), 0.25);
    return integral;
}

Eigen::AlignedBox3d bounding_box(const Corners& x) {
    Eigen::AlignedBox3d box(x[0]);
    for (const Vec3& corner : x) box.extend(corner);
    return box;
}

std::array<Corners, 8> cut_in_eight(const Corners& x) {
    const Vec3 a = (x[0] + x[1]) / 2, b = (x[0] + x[2]) / 2, c = (x[0] + x[3]) / 2;
    const Vec3 d = (x[1] + x[2]) / 2, e = (x[1] + x[3]) / 2, f = (x[2] + x[3]) / 2;
    return {{{x[0], a, b, c},
             {x[1], a, d, e},
             {x[2], b, d, f},
             {x[3], c, e, f},
             {b, e, a, c},
             {b, e, a, d},
             {b, e, c, f},
             {b, e, d, f}}};
}

/// Mean over a tet whose own four-point mean is `coarse`; depth: subdivisions made so far.
Integral refine(const StiffnessFunction& f, const Corners& x, TetId root, const Integral& coarse, int depth) {
    const int least_depth = f.has_jumps() ? 2 : 1, greatest_depth = 4;
    const std::array<Corners, 8> children = cut_in_eight(x);
    std::array<Integral, 8> means;
    std::array<bool, 8> exact;
    Integral fine;
    for (std::size_t i = 0; i < 8; ++i) {
        exact[i] = f.constant_within(bounding_box(children[i]), root);
        means[i] =
            exact[i] ? integrand(f.at((children[i][0] + children[i][1]) / 2, root)) : four_points(f, children[i], root);
        fine.add(means[i], 0.125);
    }
    ++depth;
    if (depth >= greatest_depth || (depth >= least_depth && agree(coarse, fine))) return fine;
    Integral finer;
    for (std::size_t i = 0; i < 8; ++i) {
        finer.add(exact[i] ? means[i] : refine(f, children[i], root, means[i], depth), 0.125);
    }
    return finer;
}

}  // namespace

StiffnessFunction::StiffnessFunction(MaterialFunction material) : material_(std::move(material)) {
    for (const Scalar* s : {&material_.young, &material_.poisson, &material_.density, &material_.mass_damping,
                            &material_.stiffness_damping}) {
        ENSURE(*s, "every scalar of a MaterialFunction must be set");
        if (!(*s)->constant()) return;
    }
    constant_ = evaluate(material_, Vec3::Zero(), TetId{});
}

Material StiffnessFunction::at(const Vec3& x, TetId root) const {
    return constant_ ? *constant_ : evaluate(material_, x, root);
}

bool StiffnessFunction::constant_within(const Eigen::AlignedBox3d& box, TetId root) const {
    if (constant_) return true;
    for (const Scalar* s : {&material_.young, &material_.poisson, &material_.density, &material_.mass_damping,
                            &material_.stiffness_damping}) {
        if (!(*s)->constant_within(box, root)) return false;
    }
    return true;
}

bool StiffnessFunction::has_jumps() const {
    for (const Scalar* s : {&material_.young, &material_.poisson, &material_.density, &material_.mass_damping,
                            &material_.stiffness_damping}) {
        if ((*s)->has_jumps()) return true;
    }
    return false;
}

Material mean_material(const StiffnessFunction& f, const Corners& corners, TetId root) {
    if (f.constant_within(bounding_box(corners), root)) return f.at((corners[0] + corners[1]) / 2, root);
    return mean_of(refine(f, corners, root, four_points(f, corners, root), 0));
}

}  // namespace tetfront
