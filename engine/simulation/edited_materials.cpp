#include "engine/simulation/edited_materials.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/simulation/pulls.hpp"
#include "engine/simulation/scene_material.hpp"

namespace tetfront {

namespace {

Sym6 scaled(Sym6 matrix, double factor) {
    for (double& entry : matrix.upper) entry *= factor;
    return matrix;
}

PooledPerTet<Sym6> scaled(const PooledPerTet<Sym6>& matrices, double factor) {
    std::vector<Sym6> values = matrices.values();
    for (Sym6& c : values) c = scaled(c, factor);
    return {std::move(values), matrices.numbers()};
}

PerTet<double> increased(PerTet<double> coefficients, double by, std::size_t tets) {
    if (by == 0) return coefficients;
    if (coefficients.empty()) coefficients.resize(tets, 0);
    for (TetId t : ids<TetId>(tets)) coefficients[t] += by;
    return coefficients;
}

/// [T] times the model's stiffness; of tets whose leaves differ, minus their mean.
PerTet<double> scales(const Model& model, const Edits& edits) {
    const TetTree& tree = model.tree;
    std::vector<std::pair<Sphere, double>> regions;
    for (const StiffnessEdit& edit : edits.stiffness) regions.push_back({{rest_position(model, edit.centre), edit.radius}, edit.scale});
    PerTet<double> scale(tree.tet_count(), edits.stiffness_scale);
    for (std::int64_t i = static_cast<std::int64_t>(tree.tet_count()) - 1; i >= 0; --i) {  // children before parents
        const TetId t(i);
        if (tree.is_leaf(t)) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : tree.corners(t)) middle += tree.rest(v) / 4;
            const auto last = std::find_if(regions.rbegin(), regions.rend(), [&](const auto& r) { return contains(r.first, middle); });
            if (last != regions.rend()) scale[t] *= last->second;
        } else {
            const double first = scale[*tree.children(t).begin()];
            double mean = 0;
            bool alike = first > 0;
            for (const TetId child : tree.children(t)) mean += std::abs(scale[child]) / 8, alike = alike && scale[child] == first;
            scale[t] = alike ? first : -mean;
        }
    }
    return scale;
}

/// The estimate of tets whose leaves differ. A tet whose leaves are scaled alike stands for them: its matrix is known, and a
/// parent of equal children costs nothing.
ElasticityMatrices estimated(const Model& model, const PerTet<double>& scale) {
    const TetTree& tree = model.tree;
    const CellProblem problem = estimation_settings(model.scene.estimation).problem;
    PerTet<TetId> known(tree.tet_count());
    for (const TetId t : ids<TetId>(tree.tet_count())) {
        const bool above = !tree.is_root(t) && scale[tree.parent(t)] > 0 && problem != CellProblem::isolated;  // where parents differ even so
        known[t] = above ? known[tree.parent(t)] : t;
    }
    const std::size_t count = tree.tet_count(tree.depth());
    LeafMaterials leaves{.elasticity = {}, .density = std::vector<double>(count, 1), .mass_damping = std::vector<double>(count, 0),
                         .stiffness_damping = std::vector<double>(count, 0)};
    for (const TetId t : tree.level(tree.depth())) leaves.elasticity.push_back(scaled(model.matrices.elasticity[known[t]], scale[t]));
    return estimate_elasticity(tree, leaves, problem);
}

void scale_parts(const Model& model, const Edits& edits, ElasticityMatrices& edited) {
    const ElasticityMatrices& m = model.matrices;
    const PerTet<double> scale = scales(model, edits);
    const ElasticityMatrices rim = estimated(model, scale);
    PerTet<Sym6> elasticity(scale.size()), bracket(scale.size());
    for (const TetId t : ids<TetId>(scale.size())) {
        const bool alike = scale[t] > 0;
        elasticity[t] = alike ? scaled(m.elasticity[t], scale[t]) : rim.elasticity[t];
        if (!m.bracket.empty()) bracket[t] = scaled(m.bracket[t], std::abs(scale[t]));
        if (!alike && !rim.bracket.empty())
            for (std::size_t i = 0; i < bracket[t].upper.size(); ++i) bracket[t].upper[i] += rim.bracket[t].upper[i];
    }
    edited.elasticity = PooledPerTet<Sym6>(elasticity);
    edited.bracket = PooledPerTet<Sym6>(bracket);
}

}  // namespace

std::shared_ptr<const ElasticityMatrices> edited_materials(const Model& model, const Edits& edits) {
    if (edits.stiffness_scale == 1 && edits.stiffness.empty() && edits.mass_damping == 0 && edits.stiffness_damping == 0) return nullptr;
    const ElasticityMatrices& m = model.matrices;
    const std::size_t tets = model.tree.tet_count();
    ElasticityMatrices edited{.elasticity = {},
                              .bracket = {},
                              .valid_range = m.valid_range,
                              .mass_damping = increased(m.mass_damping, edits.mass_damping, tets),
                              .stiffness_damping = increased(m.stiffness_damping, edits.stiffness_damping, tets),
                              .report = {}};
    if (edits.stiffness.empty()) {
        edited.elasticity = scaled(m.elasticity, edits.stiffness_scale);
        edited.bracket = scaled(m.bracket, edits.stiffness_scale);
    } else {
        scale_parts(model, edits, edited);
    }
    return std::make_shared<const ElasticityMatrices>(std::move(edited));
}

}  // namespace tetfront
