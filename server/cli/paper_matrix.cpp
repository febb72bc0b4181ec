// Figure 3: stress over strain of a coarse tet, sampled in its children, and the line that is fitted to it.
#include "engine/mechanics/cell_samples.hpp"
#include "engine/mechanics/cell_sampling.hpp"
#include "engine/mesh/tet_mesh.hpp"
#include "server/cli/paper_figures.hpp"
#include "server/cli/report_head.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

namespace {

constexpr double soft = 1e5, stiff = 1e6, poisson = 0.3;  // [Pa] at both ends of the tet

struct Tet {
    Eigen::Matrix<double, 3, 4> gradients;
    std::array<Sym6, 8> children;
};

/// A tet of one metre whose children's stiffness grows tenfold along x.
Tet graded_tet() {
    TetMesh cube = box_mesh(Vec3::Zero(), Vec3::Ones(), {1, 1, 1});
    cube.corners.resize(1);
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = cube.positions[cube.corners[TetId(0)][i]];
    Tet tet{corner_gradients(corners), {}};
    for (int child = 0; child < 8; ++child) {
        Vec4 barycentric = barycentric_in_parent(child, Vec4::Constant(0.25));
        double place = 0;
        for (int i = 0; i < 4; ++i) place += barycentric[i] * corners[static_cast<std::size_t>(i)].x();
        tet.children[static_cast<std::size_t>(child)] = Sym6::from(isotropic_elasticity(soft * std::pow(stiff / soft, place), poisson));
    }
    return tet;
}

/// sigma_xx over alpha_xx [kPa].
std::vector<Chart::Point> curve(CellProblem problem, const Tet& tet) {
    std::vector<double> alphas;
    for (const double alpha : {0.44, 0.4, 0.36, 0.32, 0.28, 0.24, 0.2, 0.16, 0.12, 0.08, 0.06, 0.04, 0.03, 0.02, 0.015, 0.01, 0.005}) alphas.push_back(-alpha);
    for (std::size_t i = alphas.size(); i-- > 0;) alphas.push_back(-alphas[i]);
    std::vector<Chart::Point> points;
    for (const CellSample& s : sample_curve(problem, tet.gradients, tet.children, 0, alphas)) points.push_back({s.alpha, s.stress[0] / 1e3, ""});
    return points;
}

}  // namespace

PaperFigure paper_matrix(PaperWork& work) {
    const Tet tet = graded_tet();
    const SamplingSettings settings;
    Chart chart{.title = "A coarse tet's stress over its strain",
                .subtitle = "Squares: samples, relaxed in the eight children. Lines: fitted. Vertical: ends of the valid range (mean_strain).",
                .x = "strain alpha, xx", .y = "stress, xx [kPa]", .series = {}, .rules = {}, .logarithmic_x = false, .logarithmic_y = false};
    std::string csv = "problem,alpha,stress_xx_Pa,fitted_xx_Pa\n";
    struct Method {
        CellProblem problem;
        const char *name, *label;
        SampledCell cell;
        int agreeing = 0, samples = 0;  // within the fitted range: of the line, all
        double farthest = 0;            // relative difference to the line at the ends of the samples
    };
    std::array<Method, 2> methods = {{{CellProblem::isolated, "isolated", "isolated: the paper to the letter", {}},
                                      {CellProblem::mean_strain, "mean_strain", "mean_strain: ours", {}}}};
    for (Method& m : methods) {
        m.cell = sample_cell(m.problem, tet.gradients, tet.children, nullptr, settings);
        const double slope = m.cell.elasticity(0, 0) / 1e3;
        Chart::Series dots{.name = m.label, .line = false, .points = curve(m.problem, tet)};
        for (const Chart::Point& p : dots.points) {
            csv += std::string(m.name) + "," + format_number(p.x) + "," + format_number(1e3 * p.y, "%.9g") + "," + format_number(1e3 * slope * p.x, "%.9g") + "\n";
            const double off = std::abs(p.y / (slope * p.x) - 1);
            m.farthest = std::max(m.farthest, off);
            if (p.x < m.cell.valid_range[0][0] || p.x > m.cell.valid_range[0][1]) continue;
            m.agreeing += off < settings.relative_tolerance;
            ++m.samples;
        }
        const double low = dots.points.front().x, high = dots.points.back().x;
        chart.series.push_back(std::move(dots));
        chart.series.push_back({.name = "fitted line", .line = true, .points = {{low, slope * low, ""}, {high, slope * high, ""}}, .markers = false});
    }
    const StrainRange& range = methods[1].cell.valid_range;
    chart.rules = {{"alpha min", range[0][0]}, {"alpha max", range[0][1]}};

    const auto bound = [&](CellProblem problem) { return solve_cell(problem, tet.gradients, tet.children)(0, 0) / 1e3; };
    const auto slope = [&](const Method& m) { return format_number(m.cell.elasticity(0, 0) / 1e3) + " kPa"; };
    const auto ends = [](const SampledCell& cell) { return format_number(cell.valid_range[0][0]) + " to " + format_number(cell.valid_range[0][1]); };
    PaperFigure figure;
    figure.title = "Figure 3: estimating an elasticity matrix";
    figure.setting = "One tet whose eight children's Young's modulus grows from 100 kPa to 1 MPa along x, Poisson's ratio 0.3. Stretched along x by "
                     "alpha, its edge midpoints relax, and the children's mean stress is one sample.";
    figure.pictures = {{work.write("paper_3.svg", to_svg(chart)), "Samples of stress over strain, the fitted lines, and where they stop to hold."}};
    figure.tables = {work.write("paper_3.csv", csv)};
    figure.statements = {
        {"The relation of stress and strain is a line for small deformations only; a line is fitted and outliers are ignored.",
         "Inside of the valid range " + std::to_string(methods[0].agreeing) + " of " + std::to_string(methods[0].samples) + " samples are within 1 % of the line (isolated), " +
             std::to_string(methods[1].agreeing) + " of " + std::to_string(methods[1].samples) + " (mean_strain); over all strains that could be sampled, -0.44 to 0.44 at most, they leave it by up to " +
             format_number(100 * methods[0].farthest, "%.0f") + " % and " + format_number(100 * methods[1].farthest, "%.0f") + " %.",
         verdict(methods[0].farthest > settings.relative_tolerance && methods[1].farthest > settings.relative_tolerance) +
             " The line is the one that most samples agree with, then least squares over these."},
        {"The slope is the element of the coarse matrix.",
         "C_xx,xx: " + slope(methods[0]) + " (isolated), " + slope(methods[1]) + " (mean_strain); the bounds are " +
             format_number(bound(CellProblem::uniform_stress)) + " kPa (uniform stress) and " + format_number(bound(CellProblem::average)) + " kPa (average).",
         std::string(methods[0].cell.elasticity(0, 0) / 1e3 < bound(CellProblem::uniform_stress)
                         ? "The paper's, read to the letter, is below the lower bound: a lone tet's midpoints lie on its surface, and left free without neighbours they bulge. "
                         : "The paper's, read to the letter, is within the bounds. ") +
             (methods[1].cell.elasticity(0, 0) / 1e3 >= bound(CellProblem::uniform_stress) && methods[1].cell.elasticity(0, 0) / 1e3 <= bound(CellProblem::average)
                  ? "Ours, which holds the children's mean strain to the parent's, is between them."
                  : "Ours, which holds the children's mean strain to the parent's, is outside of them.")},
        {"T1 = 1e-2 and T2 = 1e-4 bound the valid range of alpha.",
         "The same numbers give " + ends(methods[0].cell) + " (isolated), " + ends(methods[1].cell) + " (mean_strain).",
         "T2 is a stress; ours is relative to the tet's own stiffness, so that the range does not depend on units."}};
    return figure;
}

}  // namespace tetfront
