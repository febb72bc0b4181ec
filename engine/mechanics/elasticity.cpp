#include "engine/mechanics/elasticity.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mechanics/cell_problem.hpp"
#include "engine/mechanics/cell_sampling.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace tetfront {

namespace {

constexpr std::size_t grain = 64, batch = 16384;  // tets per task, tets between two reports of progress

std::size_t level_begin(const TetTree& tree, int level) { return (*tree.level(level).begin()).index(); }

/// body(t) for every tet of a level, in parallel; report(done) in between, on the calling thread.
template <class Body, class Report>
void for_level(const TetTree& tree, int level, const Body& body, const Report& report) {
    const std::size_t first = level_begin(tree, level), count = tree.tet_count(level);
    for (std::size_t done = 0; done < count; done += batch) {
        parallel_for(std::min(batch, count - done), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(TetId(static_cast<std::int64_t>(first + done + i)));
        });
        report(std::min(done + batch, count));
    }
}

std::array<Vec3, 4> corner_positions(const TetTree& tree, TetId t) {
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = tree.rest(tree.corners(t)[i]);
    return x;
}

std::array<Sym6, 8> of_children(const TetTree& tree, TetId t, const PerTet<Sym6>& values) {
    std::array<Sym6, 8> result;
    std::size_t i = 0;
    for (TetId child : tree.children(t)) result[i++] = values[child];
    return result;
}

bool all_equal(const std::array<Sym6, 8>& c) {
    return std::all_of(c.begin() + 1, c.end(), [&](const Sym6& other) { return other == c[0]; });
}

Sym6 difference(const Sym6& a, const Sym6& b) {
    Sym6 d;
    for (std::size_t i = 0; i < 21; ++i) d.upper[i] = a.upper[i] - b.upper[i];
    return d;
}

void validate(const SamplingSettings& s) {
    double before = 0;
    for (const double alpha : s.alphas) {
        if (!(alpha > before && alpha < 0.49)) {
            throw InputError("", "alphas", "hold " + std::to_string(alpha) + " after " + std::to_string(before),
                             "use ascending strains above 0 and below 0.49");
        }
        before = alpha;
    }
    if (s.alphas.empty()) throw InputError("", "alphas", "are empty", "give at least one strain");
    for (const double tolerance : {s.relative_tolerance, s.stress_tolerance}) {
        if (!(tolerance > 0 && tolerance < 1))
            throw InputError("", "tolerance", "is " + std::to_string(tolerance), "use a number in (0, 1)");
    }
}

/// The bottom-up pass over one tree.
class Estimation {
 public:
    Estimation(const TetTree& tree, const LeafMaterials& leaves, const EstimationSettings& settings)
        : tree_(tree), settings_(settings), first_leaf_(level_begin(tree, tree.depth())) {
        c_.resize(tree.tet_count());
        std::copy(leaves.elasticity.begin(), leaves.elasticity.end(),
                  c_.begin() + static_cast<std::ptrdiff_t>(first_leaf_));
        upper_ = lower_ = c_;
        notes_.resize(first_leaf_);
        if (settings.sampling) range_.assign(tree.tet_count(), unbounded_range);
    }

    ElasticityMatrices run(const EstimationProgress& progress) {
        ElasticityMatrices result;
        std::size_t done_below = 0;
        for (int level = tree_.depth() - 1; level >= 0; --level) {
            const auto start = std::chrono::steady_clock::now();
            for_level(
                tree_, level, [&](TetId t) { estimate(t); },
                [&](std::size_t done) {
                    if (progress) progress(static_cast<double>(done_below + done) / static_cast<double>(first_leaf_));
                });
            done_below += tree_.tet_count(level);
            result.report.push_back(report(level));
            result.report.back().seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        }
        result.bracket.resize(c_.size());
        parallel_for(c_.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (TetId t : ids<TetId>(static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end)))
                result.bracket[t] = difference(upper_[t], lower_[t]);
        });
        result.elasticity = std::move(c_);
        const bool ends =
            std::any_of(range_.begin(), range_.end(), [](const StrainRange& r) { return r != unbounded_range; });
        if (ends) result.valid_range = std::move(range_);
        return result;
    }

 private:
    struct Note {
        float residual = 0;
        bool uniform = false, fitted = true;
    };

    void estimate(TetId t) {
        const auto estimates = of_children(tree_, t, c_), uppers = of_children(tree_, t, upper_),
                   lowers = of_children(tree_, t, lower_);
        const bool alike = all_equal(estimates), bounds_meet = all_equal(uppers) && uppers == lowers;
        const bool copies = alike && settings_.problem != CellProblem::isolated;
        Eigen::Matrix<double, 3, 4> gradients;
        if (!copies || !bounds_meet) gradients = corner_gradients(corner_positions(tree_, t));
        upper_[t] = bounds_meet ? uppers[0] : solve_cell(CellProblem::average, gradients, uppers);
        lower_[t] = bounds_meet ? uppers[0] : solve_cell(CellProblem::uniform_stress, gradients, lowers);
        notes_[t].uniform = copies;
        if (copies) {
            c_[t] = estimates[0];
            if (settings_.sampling) range_[t] = common_range(t);
        } else if (settings_.sampling) {
            std::array<StrainRange, 8> ranges;
            std::size_t i = 0;
            for (TetId child : tree_.children(t)) ranges[i++] = range_[child];
            const SampledCell cell = sample_cell(settings_.problem, gradients, estimates, &ranges, *settings_.sampling);
            c_[t] = cell.elasticity;
            range_[t] = cell.valid_range;
            notes_[t] = {static_cast<float>(cell.residual), false, cell.fitted};
        } else {
            c_[t] = solve_cell(settings_.problem, gradients, estimates);
        }
    }

    /// Where all children are valid: their strain is the parent's.
    [[nodiscard]] StrainRange common_range(TetId t) const {
        StrainRange common = unbounded_range;
        for (TetId child : tree_.children(t))
            for (std::size_t m = 0; m < 6; ++m) {
                common[m][0] = std::max(common[m][0], range_[child][m][0]);
                common[m][1] = std::min(common[m][1], range_[child][m][1]);
            }
        return common;
    }

    [[nodiscard]] LevelReport report(int level) const {
        const auto trace = [](const Sym6& c) { return c.matrix().trace(); };
        LevelReport r;
        r.level = level;
        r.tets = static_cast<std::int64_t>(tree_.tet_count(level));
        for (TetId t : tree_.level(level)) {
            const double stiffness = trace(c_[t]);
            r.below_average += (trace(upper_[t]) - stiffness) / stiffness / static_cast<double>(r.tets);
            r.above_uniform_stress += (stiffness - trace(lower_[t])) / stiffness / static_cast<double>(r.tets);
            r.mean_residual += static_cast<double>(notes_[t].residual) / static_cast<double>(r.tets);
            r.largest_residual = std::max(r.largest_residual, static_cast<double>(notes_[t].residual));
            r.uniform += notes_[t].uniform;
            r.unfitted += !notes_[t].fitted;
            r.finite_ranges += !range_.empty() && range_[t] != unbounded_range;
        }
        return r;
    }

    const TetTree& tree_;
    const EstimationSettings& settings_;
    std::size_t first_leaf_;
    PerTet<Sym6> c_;              // [T] the estimate
    PerTet<Sym6> upper_, lower_;  // [T] both bounds, carried up on their own
    PerTet<StrainRange> range_;   // [T] or empty
    PerTet<Note> notes_;          // [T - leaves]
};

/// Leaves' values -> every tet's, by `mean(t)` of its children's.
template <class Mean>
PerTet<double> carry_up(const TetTree& tree, const std::vector<double>& leaves, const Mean& mean) {
    PerTet<double> values(tree.tet_count());
    std::copy(leaves.begin(), leaves.end(),
              values.begin() + static_cast<std::ptrdiff_t>(level_begin(tree, tree.depth())));
    for (int level = tree.depth() - 1; level >= 0; --level) {
        for_level(
            tree, level,
            [&](TetId t) {
                const double first = values[*tree.children(t).begin()];
                bool equal = true;
                for (TetId child : tree.children(t)) equal = equal && values[child] == first;
                values[t] = equal ? first : mean(t, values);
            },
            [](std::size_t) {});
    }
    return values;
}

bool all_zero(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return v == 0; });
}

void add_damping(const TetTree& tree, const LeafMaterials& leaves, CellProblem problem, ElasticityMatrices& matrices) {
    if (!all_zero(leaves.mass_damping)) {
        const PerTet<double> density = coarse_density(tree, leaves);
        matrices.mass_damping = carry_up(tree, leaves.mass_damping, [&](TetId t, const PerTet<double>& damping) {
            double sum = 0;
            for (TetId child : tree.children(t)) sum += density[child] * damping[child];
            return sum / (8 * density[t]);
        });
    }
    if (!all_zero(leaves.stiffness_damping)) {
        matrices.stiffness_damping =
            carry_up(tree, leaves.stiffness_damping, [&](TetId t, const PerTet<double>& damping) {
                std::array<double, 8> shares;
                solve_cell(problem, corner_gradients(corner_positions(tree, t)),
                           of_children(tree, t, matrices.elasticity), &shares);
                double sum = 0;
                std::size_t i = 0;
                for (TetId child : tree.children(t)) sum += shares[i++] * damping[child];
                return sum;
            });
    }
}

}  // namespace

LeafMaterials integrate_leaves(const TetTree& tree, const StiffnessFunction& function,
                               const EstimationProgress& progress) {
    const std::size_t first = level_begin(tree, tree.depth()), count = tree.tet_count(tree.depth());
    const std::size_t leaves_per_root = std::size_t{1} << (3 * tree.depth());
    LeafMaterials leaves;
    leaves.elasticity.resize(count);
    leaves.density.resize(count);
    leaves.mass_damping.resize(count);
    leaves.stiffness_damping.resize(count);
    for_level(
        tree, tree.depth(),
        [&](TetId t) {
            const std::size_t i = t.index() - first;
            const TetId root(static_cast<std::int64_t>(i / leaves_per_root));
            const Material m = mean_material(function, corner_positions(tree, t), root);
            leaves.elasticity[i] = m.elasticity;
            leaves.density[i] = m.density;
            leaves.mass_damping[i] = m.mass_damping;
            leaves.stiffness_damping[i] = m.stiffness_damping;
        },
        [&](std::size_t done) {
            if (progress) progress(static_cast<double>(done) / static_cast<double>(count));
        });
    return leaves;
}

ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves,
                                       const EstimationSettings& settings, const EstimationProgress& progress) {
    ENSURE(leaves.elasticity.size() == tree.tet_count(tree.depth()), leaves.elasticity.size());
    if (settings.sampling) validate(*settings.sampling);
    const bool uniform = std::all_of(leaves.elasticity.begin(), leaves.elasticity.end(),
                                     [&](const Sym6& leaf) { return leaf == leaves.elasticity.front(); });
    ElasticityMatrices matrices;
    if (uniform && settings.problem != CellProblem::isolated) {
        matrices.elasticity.assign(tree.tet_count(), leaves.elasticity.front());
    } else {
        matrices = Estimation(tree, leaves, settings).run(progress);
    }
    if (uniform) matrices.bracket = {};
    add_damping(tree, leaves, settings.problem, matrices);
    if (progress) progress(1);
    return matrices;
}

PerTet<double> coarse_density(const TetTree& tree, const LeafMaterials& leaves) {
    return carry_up(tree, leaves.density, [&](TetId t, const PerTet<double>& density) {
        double sum = 0;
        for (TetId child : tree.children(t)) sum += density[child];
        return sum / 8;
    });
}

}  // namespace tetfront
