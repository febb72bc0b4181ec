#pragma once
// The simulation's elements and integrators on problems whose answers are known: what the verification report tabulates and
// what verification_test asserts.
//
//     double ratio = cantilever_tip(2, 1) / timoshenko_tip_of_end_load(verification_beam, 1);
//     auto [in, out] = twisted_beam_tip(2, 2);
//     std::vector<double> tips = elastica_tips({1, 2, 5}, 50, 0);

#include "tests/support/beam_theory.hpp"
#include "tests/support/equilibrium.hpp"
#include "tests/support/scenes.hpp"
#include "tests/support/static_level.hpp"

#include <functional>
#include <string>
#include <vector>

namespace tetfront::testing {

inline constexpr SquareBeam verification_beam{8, 1, 1e6};

inline PooledPerTet<Sym6> uniform_elasticity(const TetTree& tree, double young, double poisson) {
    return PooledPerTet<Sym6>(tree.tet_count(), Sym6::from(isotropic_elasticity(young, poisson)));
}
inline PerVertex<std::uint8_t> clamped_at_zero(const TetTree& tree) {
    PerVertex<std::uint8_t> fixed(tree.vertex_count(), 0);
    for (VertexId v : ids<VertexId>(fixed.size())) fixed[v] = tree.rest(v)[0] < 1e-9;
    return fixed;
}
/// Rate of convergence of three values on meshes that are each half as wide as the one before.
inline double convergence_rate(double coarse, double middle, double fine) { return std::log2(std::abs((middle - coarse) / (fine - middle))); }

/// Tip deflection [m] of verification_beam under a unit force at its end, nu 0, on a uniform level: linear elasticity.
inline double cantilever_tip(int order, int level) {
    const SquareBeam& b = verification_beam;
    const TetTree tree(box_mesh({0, 0, 0}, {b.length, b.side, b.side}, {8, 1, 1}), order == 1 ? level : level + 1);
    return tip_deflection(tree, solve_static_level(tree, level, order, uniform_elasticity(tree, b.young, 0), end_load(tree, level, order, {0, 0, -1})));
}

/// Displacements [m] of the twisted beam's tip along a unit force: along the width of the section there, along its
/// thickness. 12 n x 2 n x n cells, each of six tets.
inline std::array<double, 2> twisted_beam_tip(int order, int n) {
    using B = TwistedBeam;
    TetMesh mesh = box_mesh({0, -B::width / 2, -B::thickness / 2}, {B::length, B::width / 2, B::thickness / 2}, {12 * n, 2 * n, n});
    for (Vec3& p : mesh.positions) {
        const double angle = p[0] / B::length * std::numbers::pi / 2;
        p = {p[0], std::cos(angle) * p[1] - std::sin(angle) * p[2], std::sin(angle) * p[1] + std::cos(angle) * p[2]};
    }
    const TetTree tree(mesh, order - 1);
    const auto elasticity = uniform_elasticity(tree, B::young, B::poisson);
    std::array<double, 2> tip{};
    for (std::size_t k = 0; k < 2; ++k) {
        const Vec3 direction = k == 0 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);  // y has turned into z
        const std::vector<Vec3> load = end_load(tree, 0, order, direction);
        const std::vector<Vec3> u = solve_static_level(tree, 0, order, elasticity, load);
        for (std::size_t v = 0; v < u.size(); ++v) tip[k] += u[v].dot(load[v]);  // mean over the end, as the force is
    }
    return tip;
}

/// Tip deflections over length of a beam of length 1 and side 0.02, nu 0, for dead end loads P L^2 / (E I), ascending; with the
/// simulation's own elements at large deformation. cells along the beam, uniform quadratic level.
inline std::vector<double> elastica_tips(const std::vector<double>& loads, int cells, int level) {
    const SquareBeam b{1, 0.02, 1e9};
    const TetTree tree(box_mesh({0, 0, 0}, {b.length, b.side, b.side}, {cells, 1, 1}), level + 1);
    const Front front(tree, 2, level, level);
    const auto elasticity = uniform_elasticity(tree, b.young, 0);
    const PerTet<double> density(tree.tet_count(), 1000);
    Equilibrium solver(front, elasticity, density, clamped_at_zero(tree));
    const std::vector<Vec3> unit = end_load(tree, level, 2, {0, 0, -1});
    std::vector<double> tips;
    double applied = 0;
    for (const double load : loads) {
        while (applied < load - 1e-9) {
            applied = std::min(load, applied + 0.1);
            const double force = applied * b.young * b.second_moment() / (b.length * b.length);
            for (std::size_t v = 0; v < unit.size(); ++v) solver.load[v] = force * unit[v];
            solver.solve(1e-7);
        }
        double tip = 0;
        for (VertexId v : front.vertices()) tip += unit[v.index()][2] * (solver.x[v][2] - tree.rest(v)[2]);  // mean over the end
        tips.push_back(tip / b.length);
    }
    return tips;
}

/// Gives each vertex a velocity [m/s] by its rest position.
inline void set_velocity(Simulation& simulation, const std::function<Vec3(const Vec3&)>& velocity) {
    PerVertex<Vec3> v;
    for (const Vec3& rest : simulation.model().tree.rest()) v.push_back(velocity(rest));
    simulation.place(simulation.all_positions(), v);
}

/// A uniform quadratic front, solved to nearly all digits.
inline std::vector<Override> exact_settings(const std::string& scheme) {
    return {{"/front/min_level", "0"},         {"/front/max_level", "0"},          {"/solver/scheme", "\"" + scheme + "\""},
            {"/solver/newton_iterations", "40"}, {"/solver/newton_tolerance", "1e-10"}, {"/solver/cg_tolerance", "1e-6"}};
}

/// A clamped beam, struck and left to swing without damping: energy over what it had at the start, after each step.
inline std::vector<double> swinging_energy(const std::string& scheme, double time_step, int steps) {
    auto settings = exact_settings(scheme);
    settings.insert(settings.end(), {{"/gravity", "[0, 0, 0]"}, {"/time_step", std::to_string(time_step)}});
    Simulation simulation(cantilever_model(settings));
    set_velocity(simulation, [](const Vec3& p) { return Vec3(0, 0, 0.3 * p[0] * p[0]); });
    const auto total = [&] { return simulation.energy().kinetic + simulation.energy().elastic; };
    const double start = total();
    std::vector<double> energy;
    for (int i = 0; i < steps; ++i) {
        ENSURE(!simulation.step().rejected, "step ", i);
        energy.push_back(total() / start);
    }
    return energy;
}

/// A free box that spins: what is left of angular momentum and energy, as the largest relative deviations.
struct Spin {
    double angular_momentum = 0, energy = 0;
};
inline Spin spinning_box(const std::string& scheme, int steps) {
    Simulation simulation(box_model(exact_settings(scheme)));
    const Vec3 omega(0.3, 0.5, 2), centre(1, 0.5, 0.5);
    set_velocity(simulation, [&](const Vec3& p) { return Vec3(omega.cross(p - centre)); });
    const auto start = simulation.momentum();
    const auto total = [&] { return simulation.energy().kinetic + simulation.energy().elastic; };
    const double energy = total();
    Spin spin;
    for (int i = 0; i < steps; ++i) {
        simulation.step();
        spin.angular_momentum = std::max(spin.angular_momentum, (simulation.momentum().angular - start.angular).norm() / start.angular.norm());
        spin.energy = std::max(spin.energy, std::abs(total() / energy - 1));
    }
    return spin;
}

/// A box turned by many rotations: the largest elastic energy over E V, and the largest nodal force over E L^2.
struct Rotated {
    double energy = 0, force = 0;
};
inline Rotated rotated_box(int order) {
    const auto model = box_model({{"/front/order", std::to_string(order)}});
    const Front front(model->tree, order, 1, 1);
    ElementSet elements;
    elements.build(front, {model->matrices.elasticity, model->density});
    PerVertex<Vec3> x(model->tree.vertex_count(), Vec3::Zero()), force(x.size());
    Rotated worst;
    for (int k = 0; k < 50; ++k) {
        const Mat3 turn = Eigen::AngleAxisd(0.2 * k, Vec3(std::sin(k), std::cos(2 * k), 0.3).normalized()).toRotationMatrix();
        for (VertexId v : front.vertices()) x[v] = turn * model->tree.rest(v) + Vec3(3, -2, k);
        elements.evaluate({.x = x, .force_scale = 1});
        elements.accumulate(force);
        worst.energy = std::max(worst.energy, elements.energy() / (1e5 * 2));
        for (VertexId v : front.vertices()) worst.force = std::max(worst.force, force[v].norm() / (1e5 * 4));
    }
    return worst;
}

/// Falls for one second: the largest distance from g t^2 / 2 [m].
inline double free_fall_error(const std::string& scheme) {
    auto settings = exact_settings(scheme);
    settings.emplace_back("/gravity", "[0, 0, -10]");
    Simulation simulation(box_model(settings));
    for (int i = 0; i < 60; ++i) simulation.step();
    const auto x = simulation.all_positions();
    double worst = 0;
    for (VertexId v : ids<VertexId>(x.size()))
        worst = std::max(worst, (x[v] - simulation.model().tree.rest(v) - Vec3(0, 0, -5)).norm());
    return worst;
}

}  // namespace tetfront::testing
