#include "engine/mechanics/elasticity.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mechanics/cell_problem.hpp"

#include <algorithm>

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

ElasticityMatrices estimate_elasticity(const TetTree& tree, const LeafMaterials& leaves, CellProblem problem,
                                       const EstimationProgress& progress) {
    ENSURE(leaves.elasticity.size() == tree.tet_count(tree.depth()), leaves.elasticity.size());
    ElasticityMatrices matrices;
    PerTet<Sym6>& c = matrices.elasticity;
    c.resize(tree.tet_count());
    const std::size_t first_leaf = level_begin(tree, tree.depth());
    std::copy(leaves.elasticity.begin(), leaves.elasticity.end(), c.begin() + static_cast<std::ptrdiff_t>(first_leaf));

    const bool uniform = std::all_of(leaves.elasticity.begin(), leaves.elasticity.end(),
                                     [&](const Sym6& leaf) { return leaf == leaves.elasticity.front(); });
    if (uniform && problem != CellProblem::isolated) {
        std::fill(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(first_leaf), leaves.elasticity.front());
        if (progress) progress(1);
        return matrices;
    }

    PerTet<Sym6> upper = c, lower = c;  // both bounds, carried up on their own
    std::size_t done_below = 0;
    for (int level = tree.depth() - 1; level >= 0; --level) {
        for_level(
            tree, level,
            [&](TetId t) {
                const auto estimates = of_children(tree, t, c), uppers = of_children(tree, t, upper),
                           lowers = of_children(tree, t, lower);
                const auto gradients = corner_gradients(corner_positions(tree, t));
                const bool bounds_meet = all_equal(uppers) && uppers == lowers;
                upper[t] = bounds_meet ? uppers[0] : solve_cell(CellProblem::average, gradients, uppers);
                lower[t] = bounds_meet ? uppers[0] : solve_cell(CellProblem::uniform_stress, gradients, lowers);
                if (problem == CellProblem::uniform_stress) {
                    c[t] = lower[t];
                } else if (all_equal(estimates) && problem != CellProblem::isolated) {
                    c[t] = estimates[0];
                } else {
                    c[t] = solve_cell(problem, gradients, estimates);
                }
            },
            [&](std::size_t done) {
                if (progress) progress(static_cast<double>(done_below + done) / static_cast<double>(first_leaf));
            });
        done_below += tree.tet_count(level);
    }
    if (!uniform) {
        matrices.bracket.resize(c.size());
        parallel_for(c.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (TetId t : ids<TetId>(static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end)))
                matrices.bracket[t] = difference(upper[t], lower[t]);
        });
    }
    return matrices;
}

PerTet<double> coarse_density(const TetTree& tree, const LeafMaterials& leaves) {
    PerTet<double> density(tree.tet_count());
    std::copy(leaves.density.begin(), leaves.density.end(),
              density.begin() + static_cast<std::ptrdiff_t>(level_begin(tree, tree.depth())));
    for (int level = tree.depth() - 1; level >= 0; --level) {
        for (TetId t : tree.level(level)) {
            double sum = 0;
            bool equal = true;
            const double first = density[*tree.children(t).begin()];
            for (TetId child : tree.children(t)) {
                sum += density[child];
                equal = equal && density[child] == first;
            }
            density[t] = equal ? first : sum / 8;
        }
    }
    return density;
}

}  // namespace tetfront
