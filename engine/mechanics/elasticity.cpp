#include "engine/mechanics/elasticity.hpp"

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/mechanics/elasticity_levels.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <unordered_map>
#include <utility>

namespace tetfront {

namespace {

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

/// The bottom-up pass over one tree. Matrices are kept once each in a pool, and tets hold their numbers: "all children
/// are alike" is then a comparison of eight integers, and a parent in a uniform part of the object costs next to
/// nothing.
class Estimation {
 public:
    Estimation(const TetTree& tree, const LeafMaterials& leaves, const EstimationSettings& settings)
        : tree_(tree), settings_(settings), first_leaf_(level_begin(tree, tree.depth())) {
        numbers_.resize(tree.tet_count());
        std::unordered_map<std::uint64_t, Number> known;
        for (std::size_t i = 0; i < leaves.elasticity.size(); ++i) {
            const Sym6& c = leaves.elasticity[i];
            Number number = i == 0 ? 0 : numbers_[leaf(i - 1)].c;
            if (i == 0 || pool_[number] != c) {
                const auto [found, is_new] = known.try_emplace(Hash().add_range(c.upper).value(), 0);
                if (is_new || pool_[found->second] != c) found->second = add(c);
                number = found->second;
            }
            numbers_[leaf(i)] = {number, number, number, 0};
        }
    }

    ElasticityMatrices run(const EstimationProgress& progress) {
        ElasticityMatrices result;
        for (int level = tree_.depth() - 1; level >= 0; --level) {
            const auto start = std::chrono::steady_clock::now();
            const std::size_t before = first_leaf_ - level_begin(tree_, level + 1);
            LevelReport report = estimate_level(level, [&](double fraction) {
                const double done =
                    static_cast<double>(before) + fraction * static_cast<double>(tree_.tet_count(level));
                if (progress) progress(done / static_cast<double>(first_leaf_));
            });
            report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            result.report.push_back(report);
        }
        const std::size_t count = tree_.tet_count();
        const bool brackets =
            std::any_of(numbers_.begin(), numbers_.end(), [](const Numbers& n) { return n.upper != n.lower; });
        const bool ends = ranges_.size() > 1;
        result.elasticity = pooled_elasticity();
        if (brackets) result.bracket = pooled_brackets();
        if (ends) {
            std::vector<Number> numbers(count);
            std::transform(numbers_.begin(), numbers_.end(), numbers.begin(), [](const Numbers& n) { return n.range; });
            result.valid_range = {std::move(ranges_), std::move(numbers)};
        }
        return result;
    }

 private:
    using Number = std::uint32_t;
    struct Numbers {
        Number c = 0, upper = 0, lower = 0;  // into pool_: the estimate and both bounds, carried up on their own
        Number range = 0;                    // into ranges_
    };
    /// What has to be computed for one parent.
    struct Work {
        TetId t;
        bool estimate, bounds;
        Sym6 c, upper, lower;
        StrainRange range = unbounded_range;
        double residual = 0;
        bool fitted = true;
    };

    /// The estimates without the bounds that stand among them in the pool.
    [[nodiscard]] PooledPerTet<Sym6> pooled_elasticity() const {
        constexpr Number none = ~Number{0};
        std::vector<Number> place(pool_.size(), none), numbers;
        std::vector<Sym6> values;
        numbers.reserve(numbers_.size());
        for (const Numbers& n : numbers_) {
            if (place[n.c] == none) {
                place[n.c] = static_cast<Number>(values.size());
                values.push_back(pool_[n.c]);
            }
            numbers.push_back(place[n.c]);
        }
        return {std::move(values), std::move(numbers)};
    }
    [[nodiscard]] PooledPerTet<Sym6> pooled_brackets() const {
        std::vector<Sym6> values = {Sym6{}};
        std::vector<Number> numbers(numbers_.size(), 0);
        for (TetId t : ids<TetId>(numbers_.size())) {
            const Numbers& n = numbers_[t];
            if (n.upper == n.lower) continue;
            Sym6 bracket;
            for (std::size_t i = 0; i < 21; ++i)
                bracket.upper[i] = pool_[n.upper].upper[i] - pool_[n.lower].upper[i];
            if (values.back() != bracket) values.push_back(bracket);
            numbers[t.index()] = static_cast<Number>(values.size() - 1);
        }
        return {std::move(values), std::move(numbers)};
    }
    [[nodiscard]] TetId leaf(std::size_t i) const { return TetId(static_cast<std::int64_t>(first_leaf_ + i)); }
    Number add(const Sym6& c) {
        pool_.push_back(c);
        return static_cast<Number>(pool_.size() - 1);
    }
    Number add(const StrainRange& range) {
        if (range == ranges_.back()) return static_cast<Number>(ranges_.size() - 1);
        if (range == unbounded_range) return 0;
        ranges_.push_back(range);
        return static_cast<Number>(ranges_.size() - 1);
    }

    /// The children's numbers; they follow one another.
    [[nodiscard]] const Numbers* children(TetId t, int level) const {
        return &numbers_[TetId(
            static_cast<std::int64_t>(level_begin(tree_, level + 1) + 8 * (t.index() - level_begin(tree_, level))))];
    }
    [[nodiscard]] std::array<Sym6, 8> matrices(const Numbers* children, Number Numbers::*which) const {
        std::array<Sym6, 8> result;
        for (std::size_t i = 0; i < 8; ++i) result[i] = pool_[children[i].*which];
        return result;
    }
    [[nodiscard]] StrainRange common_range(const Numbers* children) const {
        StrainRange common = unbounded_range;
        for (std::size_t i = 0; i < 8; ++i)
            for (std::size_t m = 0; m < 6; ++m) {
                common[m][0] = std::max(common[m][0], ranges_[children[i].range][m][0]);
                common[m][1] = std::min(common[m][1], ranges_[children[i].range][m][1]);
            }
        return common;
    }

    template <class Report>
    LevelReport estimate_level(int level, const Report& report) {
        LevelReport summary;
        summary.level = level;
        summary.tets = static_cast<std::int64_t>(tree_.tet_count(level));
        std::vector<Work> work;
        for (TetId t : tree_.level(level)) {
            const Numbers* child = children(t, level);
            bool alike = settings_.problem != CellProblem::isolated, bounds_meet = true, same_range = true;
            for (std::size_t i = 0; i < 8; ++i) {
                alike = alike && child[i].c == child[0].c;
                bounds_meet = bounds_meet && child[i].upper == child[0].upper && child[i].lower == child[0].upper;
                same_range = same_range && child[i].range == child[0].range;
            }
            numbers_[t] = child[0];  // what is not alike is replaced below
            summary.uniform += alike;
            if (alike && !same_range) numbers_[t].range = add(common_range(child));
            if (!alike || !bounds_meet) work.push_back({t, !alike, !bounds_meet, {}, {}, {}});
        }
        constexpr std::size_t batch = 4096;
        for (std::size_t done = 0; done < work.size(); done += batch) {
            parallel_for(std::min(batch, work.size() - done), 16, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) compute(work[done + i], level);
            });
            report(static_cast<double>(std::min(done + batch, work.size())) / static_cast<double>(work.size()));
        }
        for (const Work& w : work) store(w, summary);

        for (TetId t : tree_.level(level)) {
            const auto trace = [&](Number n) { return pool_[n].matrix().trace(); };
            const Numbers& n = numbers_[t];
            summary.finite_ranges += n.range != 0;
            if (n.c == n.upper && n.c == n.lower) continue;
            const double scale = trace(n.c) * static_cast<double>(summary.tets);
            summary.below_average += (trace(n.upper) - trace(n.c)) / scale;
            summary.above_uniform_stress += (trace(n.c) - trace(n.lower)) / scale;
        }
        return summary;
    }

    void compute(Work& w, int level) const {
        const Numbers* child = children(w.t, level);
        const auto gradients = corner_gradients(corner_positions(tree_, w.t));
        if (w.bounds) {
            w.upper = solve_cell(CellProblem::average, gradients, matrices(child, &Numbers::upper));
            w.lower = solve_cell(CellProblem::uniform_stress, gradients, matrices(child, &Numbers::lower));
        }
        if (!w.estimate) return;
        const std::array<Sym6, 8> estimates = matrices(child, &Numbers::c);
        if (!settings_.sampling) {
            w.c = solve_cell(settings_.problem, gradients, estimates);
            return;
        }
        std::array<StrainRange, 8> ranges;
        for (std::size_t i = 0; i < 8; ++i) ranges[i] = ranges_[child[i].range];
        const SampledCell cell = sample_cell(settings_.problem, gradients, estimates, &ranges, *settings_.sampling);
        w.c = cell.elasticity;
        w.range = cell.valid_range;
        w.residual = cell.residual;
        w.fitted = cell.fitted;
    }

    void store(const Work& w, LevelReport& summary) {
        Numbers& n = numbers_[w.t];
        if (w.bounds) {
            n.upper = add(w.upper);
            n.lower = add(w.lower);
        }
        if (!w.estimate) return;
        n.c = add(w.c);
        n.range = add(w.range);
        summary.mean_residual += w.residual / static_cast<double>(summary.tets);
        summary.largest_residual = std::max(summary.largest_residual, w.residual);
        summary.unfitted += !w.fitted;
    }

    const TetTree& tree_;
    const EstimationSettings& settings_;
    std::size_t first_leaf_;
    std::vector<Sym6> pool_;
    std::vector<StrainRange> ranges_ = {unbounded_range};
    PerTet<Numbers> numbers_;  // [T]
};

}  // namespace

ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves,
                                       const EstimationSettings& settings, const EstimationProgress& progress) {
    ENSURE(leaves.elasticity.size() == tree.tet_count(tree.depth()), leaves.elasticity.size());
    if (settings.sampling) validate(*settings.sampling);
    const bool uniform = std::all_of(leaves.elasticity.begin(), leaves.elasticity.end(),
                                     [&](const Sym6& leaf) { return leaf == leaves.elasticity.front(); });
    ElasticityMatrices matrices;
    if (uniform && settings.problem != CellProblem::isolated) {
        matrices.elasticity = {tree.tet_count(), leaves.elasticity.front()};
    } else {
        matrices = Estimation(tree, leaves, settings).run(progress);
        if (uniform) matrices.bracket = {};
    }
    add_damping(tree, leaves, settings.problem, matrices);
    if (progress) progress(1);
    return matrices;
}

}  // namespace tetfront
