#include "engine/mechanics/cell_problem.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tetfront {

namespace {

/// Displacement of the ten nodes in each mode -> gradients of the modes in each child.
template <int Modes>
ModeTable<Modes> mode_table(const Eigen::Matrix<double, 10, Modes>& nodes) {
    ModeTable<Modes> table;
    for (std::size_t c = 0; c < 8; ++c) {
        Eigen::Matrix4d corners;  // columns: the child's corners in the parent's barycentric coordinates
        for (int i = 0; i < 4; ++i) corners.col(i) = barycentric_in_parent(static_cast<int>(c), Vec4::Unit(i));
        const Eigen::Matrix4d child_gradients = corners.inverse().transpose();  // columns: of the child's coordinates
        table[c].setZero();
        for (int i = 0; i < 4; ++i) {
            table[c] += child_gradients.col(i) * nodes.row(child_nodes[c][static_cast<std::size_t>(i)]);
        }
    }
    return table;
}

using Gradients4 = Eigen::Matrix<double, 3, 4>;

/// Strain of the displacement g (x) w for w = e_x, e_y, e_z: 6x3.
Eigen::Matrix<double, 6, 3> strain_of(const Vec3& g) {
    Eigen::Matrix<double, 6, 3> b;
    b << g[0], 0, 0, 0, g[1], 0, 0, 0, g[2], 0, g[2], g[1], g[2], 0, g[0], g[1], g[0], 0;
    return b;
}

/// Energy matrices of the children -> their sum and shares.
Sym6 sum_up(const std::array<Mat6, 8>& energies, std::array<double, 8>* shares) {
    Mat6 mean = Mat6::Zero();
    for (const Mat6& e : energies) mean += e / 8;
    if (shares) {
        const Eigen::LLT<Mat6> factor(mean);
        for (std::size_t k = 0; k < 8; ++k) (*shares)[k] = factor.solve(energies[k]).trace() / 48;
    }
    return Sym6::from(mean);
}

template <int Modes>
Sym6 relax(const ModeTable<Modes>& modes, const Gradients4& gradients, const std::array<Sym6, 8>& children,
           std::array<double, 8>* energy_shares) {
    constexpr int n = 3 * Modes;
    using Strains = Eigen::Matrix<double, 6, n>;
    std::array<Strains, 8> b;
    std::array<Mat6, 8> c;
    Eigen::Matrix<double, n, n> stiffness = Eigen::Matrix<double, n, n>::Zero();
    Eigen::Matrix<double, n, 6> load = Eigen::Matrix<double, n, 6>::Zero();
    for (std::size_t k = 0; k < 8; ++k) {
        c[k] = children[k].matrix();
        for (int p = 0; p < Modes; ++p) {
            b[k].template middleCols<3>(3 * p) = strain_of(gradients * modes[k].col(p));
        }
        const Eigen::Matrix<double, n, 6> stress = (c[k] * b[k]).transpose();
        stiffness.noalias() += stress * b[k];
        load.noalias() += stress;
    }
    const Eigen::LDLT<Eigen::Matrix<double, n, n>> factor(stiffness);
    ENSURE(factor.info() == Eigen::Success && factor.isPositive(), "cell problem is not positive definite");
    const Eigen::Matrix<double, n, 6> fluctuation = -factor.solve(load);
    // As a sum of positive matrices, not as <C> minus the relaxation: no cancellation at high contrast.
    std::array<Mat6, 8> energies;
    for (std::size_t k = 0; k < 8; ++k) {
        const Mat6 strain = Mat6::Identity() + b[k] * fluctuation;
        energies[k].noalias() = strain.transpose() * (c[k] * strain);
    }
    return sum_up(energies, energy_shares);
}

}  // namespace

const ModeTable<3>& mean_strain_modes() {
    static const ModeTable<3> table = [] {
        Eigen::Matrix<double, 10, 3> nodes = Eigen::Matrix<double, 10, 3>::Zero();
        for (int edge = 0; edge < 6; ++edge) nodes(4 + edge, edge < 3 ? edge : 5 - edge) = 1;  // 01-23, 02-13, 03-12
        return mode_table<3>(nodes);
    }();
    return table;
}

const ModeTable<6>& isolated_modes() {
    static const ModeTable<6> table = [] {
        Eigen::Matrix<double, 10, 6> nodes = Eigen::Matrix<double, 10, 6>::Zero();
        nodes.bottomRows<6>().setIdentity();
        return mode_table<6>(nodes);
    }();
    return table;
}

const ModeTable<6>& uniform_stress_modes() {
    static const ModeTable<6> table = [] {
        Eigen::Matrix<double, 10, 6> nodes = Eigen::Matrix<double, 10, 6>::Zero();
        nodes.bottomRows<6>().setIdentity();
        for (int edge = 0; edge < 6; ++edge) {
            for (int end : tet_edges[static_cast<std::size_t>(edge)]) nodes(end, edge) = -3;
        }
        return mode_table<6>(nodes);
    }();
    return table;
}

Gradients4 corner_gradients(const std::array<Vec3, 4>& x) {
    Mat3 edges;
    edges << x[1] - x[0], x[2] - x[0], x[3] - x[0];
    Gradients4 g;
    g.rightCols<3>() = edges.inverse().transpose();
    g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
    return g;
}

Sym6 solve_cell(CellProblem problem, const Gradients4& gradients, const std::array<Sym6, 8>& children,
                std::array<double, 8>* energy_shares) {
    switch (problem) {
        case CellProblem::mean_strain:
            return relax(mean_strain_modes(), gradients, children, energy_shares);
        case CellProblem::isolated:
            return relax(isolated_modes(), gradients, children, energy_shares);
        case CellProblem::uniform_stress:
            return relax(uniform_stress_modes(), gradients, children, energy_shares);
        case CellProblem::average:
            break;
    }
    std::array<Mat6, 8> energies;
    for (std::size_t k = 0; k < 8; ++k) energies[k] = children[k].matrix();
    return sum_up(energies, energy_shares);
}

}  // namespace tetfront
