#include "engine/material/stiffness.hpp"

#include "engine/base/error.hpp"

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <utility>

namespace tetfront {

namespace {

void require(bool holds, const char* what, const ScalarFunction& source, double value, const Vec3& x,
             const char* allowed) {
    if (holds) return;
    std::ostringstream where, problem;
    where << what << " at (" << x.transpose() << ')';
    problem << "is " << value;
    if (const std::string name = source.source(x); !name.empty()) problem << ", from " << name;
    throw InputError("", where.str(), problem.str(), allowed);
}

/// orthotropic: C of f.orthotropic, null for an isotropic material.
Material evaluate(const MaterialFunction& f, const Sym6* orthotropic, const Vec3& x, TetId root) {
    Material m;
    if (orthotropic) {
        const double scale = f.scale->at(x, root);
        require(scale > 0 && std::isfinite(scale), "scale of the stiffness", *f.scale, scale, x, "must be finite and above 0");
        m.elasticity = *orthotropic;
        for (double& entry : m.elasticity.upper) entry *= scale;
    } else {
        const double young = f.young->at(x, root), poisson = f.poisson->at(x, root);
        require(young > 0 && std::isfinite(young), "Young's modulus", *f.young, young, x, "must be finite and above 0");
        require(poisson > -1 && poisson < 0.5, "Poisson's ratio", *f.poisson, poisson, x, "must be above -1 and below 0.5");
        m.elasticity = Sym6::from(isotropic_elasticity(young, poisson));
    }
    m.density = f.density->at(x, root);
    m.mass_damping = f.mass_damping->at(x, root);
    m.stiffness_damping = f.stiffness_damping->at(x, root);
    require(m.density > 0 && std::isfinite(m.density), "density", *f.density, m.density, x, "must be finite and above 0");
    require(m.mass_damping >= 0 && std::isfinite(m.mass_damping), "mass damping", *f.mass_damping, m.mass_damping, x,
            "must be at least 0");
    require(m.stiffness_damping >= 0 && std::isfinite(m.stiffness_damping), "stiffness damping",
            *f.stiffness_damping, m.stiffness_damping, x,
            "must be at least 0");
    return m;
}

/// The scalars that matter.
std::vector<const ScalarFunction*> scalars(const MaterialFunction& f) {
    std::vector<const ScalarFunction*> list = {f.density.get(), f.mass_damping.get(), f.stiffness_damping.get()};
    if (f.orthotropic) {
        list.push_back(f.scale.get());
    } else {
        list.push_back(f.young.get());
        list.push_back(f.poisson.get());
    }
    return list;
}

/// Sums of what mean_material averages. Where every sample is the same material the mean is that very material: sums of
/// rounded parts would make tets that only touch a boundary differ from their neighbours by one bit.
struct Integral {
    Sym6 elasticity;
    double density = 0, mass_damping = 0, stiffness_damping = 0;
    std::optional<Material> first = {};
    bool one_material = true;

    void add(const Integral& other, double weight) {
        one_material = one_material && other.one_material && (!first || *first == *other.first);
        if (!first) first = other.first;
        for (std::size_t i = 0; i < 21; ++i) elasticity.upper[i] += weight * other.elasticity.upper[i];
        density += weight * other.density;
        mass_damping += weight * other.mass_damping;
        stiffness_damping += weight * other.stiffness_damping;
    }
};

double stiffness_of(const Sym6& c) { return c(0, 0) + c(1, 1) + c(2, 2) + 2 * (c(3, 3) + c(4, 4) + c(5, 5)); }

Integral integrand(const Material& m) {
    return {m.elasticity, m.density, m.density * m.mass_damping, stiffness_of(m.elasticity) * m.stiffness_damping, m};
}

Material mean_of(const Integral& i) {
    if (i.one_material) return *i.first;
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

StiffnessFunction::StiffnessFunction(MaterialFunction material) { add_zone(std::move(material)); }

StiffnessFunction::StiffnessFunction(Zones zones, std::vector<MaterialFunction> materials)
    : where_(std::move(zones)), has_jumps_(true) {
    for (MaterialFunction& material : materials) add_zone(std::move(material));
}

void StiffnessFunction::add_zone(MaterialFunction material) {
    Zone zone{std::move(material), {}, {}};
    if (zone.function.orthotropic) zone.orthotropic = orthotropic(*zone.function.orthotropic);
    bool never_changes = true;
    for (const ScalarFunction* s : scalars(zone.function)) {
        ENSURE(s, "every scalar of a MaterialFunction must be set");
        never_changes = never_changes && s->constant();
        has_jumps_ = has_jumps_ || s->has_jumps();
    }
    if (never_changes) {
        zone.constant = evaluate(zone.function, zone.orthotropic ? &*zone.orthotropic : nullptr, Vec3::Zero(), TetId{});
    }
    zones_.push_back(std::move(zone));
}

const StiffnessFunction::Zone& StiffnessFunction::zone_at(const Vec3& x, TetId root) const {
    if (!where_) return zones_.front();
    const int zone = where_->zone(x, root);
    if (zone < 0 || static_cast<std::size_t>(zone) >= zones_.size()) {
        std::ostringstream where;
        where << "position (" << x.transpose() << ')';
        throw InputError("", where.str(), "lies in zone " + std::to_string(zone) + " of the material",
                         "give materials for zones 0 to " + std::to_string(zone));
    }
    return zones_[static_cast<std::size_t>(zone)];
}

Material StiffnessFunction::at(const Vec3& x, TetId root) const {
    const Zone& zone = zone_at(x, root);
    return zone.constant ? *zone.constant
                         : evaluate(zone.function, zone.orthotropic ? &*zone.orthotropic : nullptr, x, root);
}

bool StiffnessFunction::constant_within(const Eigen::AlignedBox3d& box, TetId root) const {
    if (where_ && !where_->one_zone_within(box, root)) return false;
    const Zone& zone = zone_at(box.center(), root);
    if (zone.constant) return true;
    for (const ScalarFunction* s : scalars(zone.function))
        if (!s->constant_within(box, root)) return false;
    return true;
}

void StiffnessFunction::hash_into(Hash& hash) const {
    if (where_) where_->hash_into(hash);
    hash.add(zones_.size());
    std::map<const ScalarFunction*, std::uint64_t> done;  // zones may share an image of gigabytes
    for (const Zone& zone : zones_) {
        if (zone.orthotropic) hash.add("orthotropic").add_range(zone.orthotropic->upper);
        for (const ScalarFunction* s : scalars(zone.function)) {
            const auto [found, is_new] = done.try_emplace(s, 0);
            if (is_new) {
                Hash own;
                s->hash_into(own);
                found->second = own.value();
            }
            hash.add(found->second);
        }
    }
}

Material mean_material(const StiffnessFunction& f, const Corners& corners, TetId root) {
    if (f.constant_within(bounding_box(corners), root)) return f.at((corners[0] + corners[1]) / 2, root);
    return mean_of(refine(f, corners, root, four_points(f, corners, root), 0));
}

}  // namespace tetfront
