// From the stiffness function to the leaves, and the means of scalars on every level.

#include "engine/mechanics/elasticity.hpp"
#include "engine/mechanics/elasticity_levels.hpp"

namespace tetfront {

namespace {

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

PerTet<double> coarse_density(const TetTree& tree, const LeafMaterials& leaves) {
    return carry_up(tree, leaves.density, [&](TetId t, const PerTet<double>& density) {
        double sum = 0;
        for (TetId child : tree.children(t)) sum += density[child];
        return sum / 8;
    });
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
                std::array<Sym6, 8> children_c;
                std::array<double, 8> shares;
                std::transform(tree.children(t).begin(), tree.children(t).end(), children_c.begin(),
                               [&](TetId child) { return matrices.elasticity[child]; });
                solve_cell(problem, corner_gradients(corner_positions(tree, t)), children_c, &shares);
                double sum = 0;
                std::size_t i = 0;
                for (TetId child : tree.children(t)) sum += shares[i++] * damping[child];
                return sum;
            });
    }
}

}  // namespace tetfront
