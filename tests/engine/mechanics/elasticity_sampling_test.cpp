#include "engine/base/error.hpp"
#include "engine/mechanics/cell_fit.hpp"
#include "engine/mechanics/elasticity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

using Corners = std::array<Vec3, 4>;
const Corners some_tet = {{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1.2, 0.1}, {0.1, 0.3, 0.8}}};

std::array<Sym6, 8> random_children(unsigned seed, double contrast, double poisson = 0.3) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> exponent(0, std::log(contrast));
    std::array<Sym6, 8> children;
    for (Sym6& c : children) c = isotropic(1e4 * std::exp(exponent(random)), poisson);
    return children;
}

double least_eigenvalue(const Mat6& m) {
    return Eigen::SelfAdjointEigenSolver<Mat6>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// ---- the fit

double median_of_slopes(std::span<const double> alphas, std::span<const double> sigmas) {
    std::vector<double> slopes;
    for (std::size_t i = 0; i < alphas.size(); ++i) slopes.push_back(sigmas[i] / alphas[i]);
    std::nth_element(slopes.begin(), slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2), slopes.end());
    return slopes[slopes.size() / 2];
}
double least_squares(std::span<const double> alphas, std::span<const double> sigmas) {
    return std::inner_product(alphas.begin(), alphas.end(), sigmas.begin(), 0.0) /
           std::inner_product(alphas.begin(), alphas.end(), alphas.begin(), 0.0);
}

TEST(CellFit, PlantedOutliersAreIgnored) {
    const LinearLaw law{1e-2, 1e-4 * 5};
    std::mt19937 random(1);
    std::uniform_real_distribution<double> noise(-1e-3, 1e-3), wrong(-20, 20);
    for (int round = 0; round < 100; ++round) {
        std::vector<double> alphas, sigmas;
        for (int i = 1; i <= 14; ++i) {
            alphas.push_back((i % 2 ? 1 : -1) * 0.02 * i);
            sigmas.push_back(5 * alphas.back() * (1 + noise(random)));
        }
        for (int i = 0; i < 4; ++i) sigmas[random() % sigmas.size()] = wrong(random);
        EXPECT_NEAR(fit_slope(alphas, sigmas, law), 5, 0.01);
    }
}

TEST(CellFit, OneGrossOutlierRuinsLeastSquares) {  // so the test above can fail
    const std::vector<double> alphas = {-0.02, -0.01, 0.01, 0.02}, sigmas = {-0.1, -0.05, 0.05, 30};
    EXPECT_GT(least_squares(alphas, sigmas), 100);
    EXPECT_NEAR(fit_slope(alphas, sigmas, {1e-2, 1e-4}), 5, 1e-12);
}

TEST(CellFit, AMissingSideDoesNotBendTheLineAsItBendsTheMedian) {
    // sigma = 5 alpha (1 + alpha): the left samples are missing, the right ones leave the line.
    std::vector<double> alphas, sigmas;
    for (const double alpha : {-0.0025, 0.0025, 0.005, 0.01, 0.16, 0.24, 0.32, 0.4, 0.45}) {
        alphas.push_back(alpha);
        sigmas.push_back(5 * alpha * (1 + alpha));
    }
    EXPECT_NEAR(fit_slope(alphas, sigmas, {1e-2, 1e-4 * 5}), 5, 0.1);
    EXPECT_GT(median_of_slopes(alphas, sigmas), 5.5);
}

// ---- one cell

TEST(CellSampling, UniformChildrenAreLinearInGreenStrainAsFarAsTheyAreSampled) {
    std::array<Sym6, 8> children;
    children.fill(isotropic(1e5, 0.3));
    const SamplingSettings settings;
    for (CellProblem problem : {CellProblem::mean_strain, CellProblem::uniform_stress}) {
        const SampledCell cell = sample_cell(problem, corner_gradients(some_tet), children, nullptr, settings);
        EXPECT_LT((cell.elasticity.matrix() - children[0].matrix()).norm(), 1e-6 * children[0].matrix().norm());
        for (std::size_t m = 0; m < 6; ++m) EXPECT_GE(cell.valid_range[m][1], 0.08) << m;
        for (std::size_t m = 0; m < 6; ++m) EXPECT_LE(cell.valid_range[m][0], -0.04) << m;
    }
}

TEST(CellSampling, FitIsNearTheTangentAndRangesEndWhereTheLawDoes) {
    const auto gradients = corner_gradients(some_tet);
    SamplingSettings settings;
    for (unsigned seed = 0; seed < 20; ++seed) {
        const auto children = random_children(seed, 100);
        const SampledCell cell = sample_cell(CellProblem::mean_strain, gradients, children, nullptr, settings);
        const Mat6 tangent = solve_cell(CellProblem::mean_strain, gradients, children).matrix();
        EXPECT_LT((cell.elasticity.matrix() - tangent).norm(), 0.05 * tangent.norm());
        EXPECT_GT(least_eigenvalue(cell.elasticity.matrix()), 0);
        EXPECT_TRUE(cell.fitted);
        EXPECT_GT(cell.samples, 20);
        for (std::size_t m = 0; m < 6; ++m) {
            EXPECT_LT(cell.valid_range[m][0], -1e-4);
            EXPECT_GT(cell.valid_range[m][1], 1e-4);
            EXPECT_GE(cell.valid_range[m][0], -0.32);
            EXPECT_LE(cell.valid_range[m][1], 0.32);
        }
    }
}

/// The bulk stiffness of nearly incompressible material must not loosen what is asked of its shear: T2 goes by pairs.
TEST(CellSampling, NearIncompressibilityDoesNotLoosenTheShear) {
    const auto shear_width = [](double poisson) {
        std::array<Sym6, 8> children;
        for (std::size_t i = 0; i < 8; ++i) children[i] = isotropic(i % 2 ? 1e4 : 2e4, poisson);
        const StrainRange range =
            sample_cell(CellProblem::mean_strain, corner_gradients(some_tet), children, nullptr, {}).valid_range;
        double width = 0;
        for (std::size_t m = 3; m < 6; ++m) width += range[m][1] - range[m][0];
        return width;
    };
    EXPECT_LT(shear_width(0.499), shear_width(0.3));
}

TEST(CellSampling, LooserThresholdsWidenTheRanges) {
    const auto gradients = corner_gradients(some_tet);
    const auto children = random_children(5, 30);
    SamplingSettings tight, loose;
    loose.relative_tolerance = 4e-2;
    loose.stress_tolerance = 4e-4;
    const auto width = [&](const SamplingSettings& s) {
        double sum = 0;
        for (const auto& r : sample_cell(CellProblem::mean_strain, gradients, children, nullptr, s).valid_range)
            sum += r[1] - r[0];
        return sum;
    };
    EXPECT_GT(width(loose), 1.5 * width(tight));
}

TEST(CellSampling, AChildsRangeLimitsItsParent) {
    const auto gradients = corner_gradients(some_tet);
    const auto children = random_children(5, 3);
    std::array<StrainRange, 8> ranges;
    ranges.fill(unbounded_range);
    const auto free = sample_cell(CellProblem::mean_strain, gradients, children, &ranges, {});
    for (auto& r : ranges[2]) r = {-1e-3, 1e-3};
    const auto limited = sample_cell(CellProblem::mean_strain, gradients, children, &ranges, {});
    for (std::size_t m = 0; m < 6; ++m) {
        EXPECT_LT(limited.valid_range[m][1], 0.2 * free.valid_range[m][1]);
        EXPECT_GT(limited.valid_range[m][0], 0.2 * free.valid_range[m][0]);
    }
}

TEST(CellSampling, UnitsChangeNothingButTheUnit) {
    const auto children = random_children(3, 100);
    std::array<Sym6, 8> megapascals = children;
    for (Sym6& c : megapascals)
        for (double& entry : c.upper) entry *= 1e-6;
    Corners millimetres = some_tet;
    for (Vec3& x : millimetres) x *= 1e3;
    for (CellProblem problem : {CellProblem::mean_strain, CellProblem::isolated}) {
        const SampledCell a = sample_cell(problem, corner_gradients(some_tet), children, nullptr, {});
        const SampledCell b = sample_cell(problem, corner_gradients(millimetres), megapascals, nullptr, {});
        EXPECT_LT((a.elasticity.matrix() - 1e6 * b.elasticity.matrix()).norm(), 1e-9 * a.elasticity.matrix().norm());
        for (std::size_t m = 0; m < 6; ++m)
            for (std::size_t side = 0; side < 2; ++side)
                EXPECT_NEAR(a.valid_range[m][side], b.valid_range[m][side], 1e-6 * std::abs(a.valid_range[m][side]));
    }
}

TEST(CellSampling, RotatedCellHasTheRotatedMatrix) {
    const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
    Corners turned = some_tet;
    for (Vec3& x : turned) x = rotation * x;
    std::array<Sym6, 8> children, turned_children;
    std::mt19937 random(9);
    std::uniform_real_distribution<double> factor(1, 50);
    for (std::size_t k = 0; k < 8; ++k) {
        Orthotropic fibres{
            .young = {1e5 * factor(random), 1e5, 1e5}, .poisson = {0.3, 0.2, 0.2}, .shear = {3e4, 4e4, 4e4}};
        children[k] = orthotropic(fibres);
        fibres.frame = rotation;
        turned_children[k] = orthotropic(fibres);
    }
    const Mat6 bond = bond_matrix(rotation);
    for (CellProblem problem :
         {CellProblem::average, CellProblem::mean_strain, CellProblem::isolated, CellProblem::uniform_stress}) {
        const Mat6 expected =
            bond * solve_cell(problem, corner_gradients(some_tet), children).matrix() * bond.transpose();
        const Mat6 c = solve_cell(problem, corner_gradients(turned), turned_children).matrix();
        EXPECT_LT((c - expected).norm(), 1e-11 * expected.norm());
    }
}

TEST(CellSampling, ContrastOfAMillionAndNearlyIncompressible) {
    for (unsigned seed = 0; seed < 10; ++seed)
        for (CellProblem problem : {CellProblem::mean_strain, CellProblem::isolated, CellProblem::uniform_stress}) {
            const SampledCell cell =
                sample_cell(problem, corner_gradients(some_tet), random_children(seed, 1e6, 0.49), nullptr, {});
            EXPECT_TRUE(cell.elasticity.matrix().allFinite());
            EXPECT_GT(least_eigenvalue(cell.elasticity.matrix()), 0);
            for (const auto& range : cell.valid_range) {
                EXPECT_LE(range[0], 0);
                EXPECT_GE(range[1], 0);
            }
        }
}

// ---- whole trees

TEST(ElasticitySampling, UniformPartsHaveNoEndAndLayersDo) {
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {4, 1, 1}), 2);
    const StiffnessFunction f(layers(0, {0.125, 0.25, 0.375, 0.5}), {{.young = constant(1e4)},
                                                                     {.young = constant(1e6)},
                                                                     {.young = constant(1e4)},
                                                                     {.young = constant(1e6)},
                                                                     {.young = constant(1e4)}});
    EstimationSettings settings;
    settings.sampling.emplace();
    const LeafMaterials leaves = integrate_leaves(tree, f);
    const ElasticityMatrices m = estimate_elasticity(tree, leaves, settings);
    ASSERT_EQ(m.valid_range.size(), tree.tet_count());
    int finite = 0, infinite = 0;
    for (TetId t : tree.level(0)) {
        const bool uniform = m.elasticity[t] == isotropic(1e4, 0.3);
        EXPECT_EQ(m.valid_range[t] == unbounded_range, uniform);
        (uniform ? infinite : finite)++;
    }
    EXPECT_EQ(finite, 6);
    EXPECT_EQ(infinite, 18);
    ASSERT_EQ(m.report.size(), 2U);
    EXPECT_EQ(m.report[1].finite_ranges, 6);
    EXPECT_EQ(m.report[1].uniform, 18);
    EXPECT_GT(m.report[1].below_average, 0);
}

TEST(ElasticitySampling, UniformObjectNeedsNoSampling) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 2);
    EstimationSettings settings;
    settings.sampling.emplace();
    const auto m = estimate_elasticity(tree, integrate_leaves(tree, StiffnessFunction(MaterialFunction{})), settings);
    EXPECT_TRUE(m.valid_range.empty());
    EXPECT_EQ(m.elasticity.values(), std::vector<Sym6>{isotropic(1e5, 0.3)}) << "once for all tets";
}

TEST(ElasticitySampling, RefusesAlphasOutOfRange) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 1);
    const LeafMaterials leaves = integrate_leaves(tree, StiffnessFunction(MaterialFunction{}));
    for (const std::vector<double>& alphas : {std::vector<double>{}, {0.1, 0.05}, {0.1, 0.6}, {-0.1}}) {
        EstimationSettings settings;
        settings.sampling.emplace().alphas = alphas;
        EXPECT_THROW(estimate_elasticity(tree, leaves, settings), InputError);
    }
}

TEST(ElasticitySampling, DampingIsAMeanByMassAndByEnergy) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 2);
    const StiffnessFunction f(layers(0, {0.25}), {{.young = constant(1e4),
                                                   .density = constant(1000),
                                                   .mass_damping = constant(1),
                                                   .stiffness_damping = constant(0.01)},
                                                  {.young = constant(1e6),
                                                   .density = constant(3000),
                                                   .mass_damping = constant(2),
                                                   .stiffness_damping = constant(0.03)}});
    const LeafMaterials leaves = integrate_leaves(tree, f);
    const ElasticityMatrices m = estimate_elasticity(tree, leaves, CellProblem::mean_strain);
    const PerTet<double> density = coarse_density(tree, leaves);
    double mass = 0, damped = 0;
    for (TetId t : tree.level(0)) {
        mass += density[t] * tree.volume(t);
        damped += density[t] * tree.volume(t) * m.mass_damping[t];
        EXPECT_GT(m.stiffness_damping[t], 0.01);
        EXPECT_LE(m.stiffness_damping[t], 0.03 + 1e-15);
    }
    EXPECT_NEAR(mass, 0.25 * 1000 + 0.75 * 3000, 1e-9);
    EXPECT_NEAR(damped, 0.25 * 1000 * 1 + 0.75 * 3000 * 2, 1e-9);
    // Nothing said about damping: no arrays.
    const auto undamped = estimate_elasticity(tree, integrate_leaves(tree, StiffnessFunction(MaterialFunction{})),
                                              CellProblem::mean_strain);
    EXPECT_TRUE(undamped.mass_damping.empty());
    EXPECT_TRUE(undamped.stiffness_damping.empty());
}

TEST(ElasticitySampling, ProgressGrowsToOne) {
    const TetTree tree(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 2);
    const StiffnessFunction f({.young = gradient(0, {0, 1}, {1e4, 1e6}, Interpolation::linear)});
    std::vector<double> seen;
    estimate_elasticity(tree, integrate_leaves(tree, f), CellProblem::mean_strain,
                        [&](double p) { seen.push_back(p); });
    ASSERT_GE(seen.size(), 3U);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
    EXPECT_EQ(seen.back(), 1);
}

}  // namespace
}  // namespace tetfront
