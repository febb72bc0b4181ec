#pragma once
// Static equilibrium of a front under dead loads with the simulation's own elements: Newton's method with the derivative of
// their forces by central differences and a sparse direct factorisation. For verification: slow, but to any tolerance, and with
// no approximation in the tangent. Full steps only: a slender beam's first step stretches it, which no line search would
// accept, and the second step takes that back. So loads must grow in steps.
//
//     Equilibrium solver(front, elasticity, density, fixed);      // fixed: [V] nonzero stays in place
//     solver.load = end_load(tree, level, 2, {0, 0, -1});         // [V] [N]
//     solver.solve(1e-8);
//     solver.x[v]

#include "engine/base/error.hpp"
#include "engine/mechanics/elements.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace tetfront {

class Equilibrium {
 public:
    /// Without hanging vertices: a uniform front.
    Equilibrium(const Front& front, const PooledPerTet<Sym6>& elasticity, const PerTet<double>& density,
                const PerVertex<std::uint8_t>& fixed)
        : load(front.tree().vertex_count(), Vec3::Zero()), x(front.tree().rest()), front_(front), number_(x.size(), -1), nodal_(x.size()) {
        ENSURE(front.hanging().empty(), "hanging vertices");
        elements_.build(front, {elasticity, density});
        for (VertexId v : front.vertices()) {
            if (fixed[v]) continue;
            number_[v] = static_cast<int>(unknown_.size());
            unknown_.push_back(v);
        }
        neighbours_.resize(unknown_.size());
        for (TetId t : front.active()) {
            const auto node = front.nodes(t);
            for (std::size_t i = 0; i < static_cast<std::size_t>(front.nodes_per_tet()); ++i)
                for (std::size_t j = 0; j < static_cast<std::size_t>(front.nodes_per_tet()); ++j)
                    if (number_[node[i]] >= 0 && number_[node[j]] >= 0) neighbours_[static_cast<std::size_t>(number_[node[i]])].insert(number_[node[j]]);
        }
        colour();
        spacing_ = std::cbrt(front.tree().volume(front.active().front()));
    }

    /// To |residual| <= tolerance * |load|; returns the number of iterations. Throws LogicError when it takes more than `most`.
    int solve(double tolerance, int most = 60) {
        double target = 0;
        for (VertexId v : unknown_) target += load[v.index()].squaredNorm();
        target = tolerance * std::sqrt(target);
        Eigen::VectorXd force = residual();
        for (int iteration = 0; iteration < most; ++iteration) {
            if (force.norm() <= target) return iteration;
            const Eigen::VectorXd direction = newton_direction(force);
            for (std::size_t i = 0; i < unknown_.size(); ++i) x[unknown_[i]] += direction.segment<3>(static_cast<Eigen::Index>(3 * i));
            force = residual();
        }
        throw LogicError("no equilibrium after " + std::to_string(most) + " iterations");
    }

    std::vector<Vec3> load;  // [V] [N]
    PerVertex<Vec3> x;       // [V] [m]

 private:
    Eigen::VectorXd residual() {
        elements_.evaluate({.x = x, .force_scale = 1});
        elements_.accumulate(nodal_);
        Eigen::VectorXd force(3 * unknown_.size());
        for (std::size_t i = 0; i < unknown_.size(); ++i)
            force.segment<3>(static_cast<Eigen::Index>(3 * i)) = nodal_[unknown_[i]] + load[unknown_[i].index()];
        return force;
    }
    /// Vertices of one colour have no neighbour in common: they may be moved at once.
    void colour() {
        std::vector<int> colour_of(unknown_.size(), -1);
        for (std::size_t i = 0; i < unknown_.size(); ++i) {
            std::set<int> taken;
            for (int n : neighbours_[i])
                for (int m : neighbours_[static_cast<std::size_t>(n)]) taken.insert(colour_of[static_cast<std::size_t>(m)]);
            while (taken.contains(++colour_of[i])) {
            }
            colours_.resize(std::max(colours_.size(), static_cast<std::size_t>(colour_of[i]) + 1));
            colours_[static_cast<std::size_t>(colour_of[i])].push_back(static_cast<int>(i));
        }
    }
    Eigen::VectorXd newton_direction(const Eigen::VectorXd& force) {
        std::vector<Eigen::Triplet<double>> entries;
        const double h = 1e-5 * spacing_;
        for (const std::vector<int>& colour : colours_) {
            for (int c = 0; c < 3; ++c) {
                const auto shift = [&](double by) {
                    for (int i : colour) x[unknown_[static_cast<std::size_t>(i)]][c] += by;
                };
                shift(h);
                const Eigen::VectorXd plus = residual();
                shift(-2 * h);
                const Eigen::VectorXd minus = residual();
                shift(h);
                for (int i : colour)
                    for (int n : neighbours_[static_cast<std::size_t>(i)])
                        for (int r = 0; r < 3; ++r) entries.emplace_back(3 * n + r, 3 * i + c, (minus[3 * n + r] - plus[3 * n + r]) / (2 * h));
            }
        }
        Eigen::SparseMatrix<double> matrix(force.size(), force.size());
        matrix.setFromTriplets(entries.begin(), entries.end());
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
        ENSURE(factor.info() == Eigen::Success, "singular tangent");
        return factor.solve(force);
    }

    const Front& front_;
    ElementSet elements_;
    PerVertex<int> number_;                   // [V of the tree] -1: fixed or not in the front
    std::vector<VertexId> unknown_;
    std::vector<std::set<int>> neighbours_;   // [unknowns] numbers of those that share a tet, itself included
    std::vector<std::vector<int>> colours_;   // numbers
    PerVertex<Vec3> nodal_;
    double spacing_ = 0;                      // [m]
};

}  // namespace tetfront
