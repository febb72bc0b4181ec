#include "engine/mechanics/multilevel.hpp"

#include <algorithm>

#include "engine/base/error.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace {

/// Mean over the three directions of the diagonal of B(G)^T C B(G), per volume.
double mean_stiffness(const Sym6& c, const Vec3& g) {
    Eigen::Matrix<double, 6, 3> b = Eigen::Matrix<double, 6, 3>::Zero();
    b(0, 0) = b(5, 1) = b(4, 2) = g[0];
    b(1, 1) = b(5, 0) = b(3, 2) = g[1];
    b(2, 2) = b(4, 0) = b(3, 1) = g[2];
    double trace = 0;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) trace += b(i, k) * c(i, j) * b(j, k);
    return trace / 3;
}

}  // namespace

void Multilevel::build(const Front& front, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned,
                       const BlockMatrix& matrix) {
    const TetTree& tree = front.tree();
    const auto& vertices = front.vertices();
    vertices_ = vertices;
    slot_.resize(tree.vertex_count());
    for (std::size_t s = 0; s < vertices.size(); ++s) slot_[vertices[s]] = static_cast<std::int32_t>(s);
    ends_.resize(vertices.size());
    dof_.assign(vertices.size(), -1);
    fixed_.resize(vertices.size());
    for (std::size_t s = 0; s < vertices.size(); ++s) {
        const auto& edge = tree.split_edge(vertices[s]);
        ends_[s] = edge[0].valid() ? std::array{slot_[edge[0]], slot_[edge[1]]} : std::array{-1, -1};
        fixed_[s] = pinned[vertices[s]];
    }
    for (std::size_t i = 0; i < matrix.size(); ++i) dof_[static_cast<std::size_t>(slot_[matrix.vertices()[i]])] = static_cast<std::int32_t>(i);

    // Vertices are numbered level by level, so a level is a range of slots.
    const int finest = vertices.empty() ? 0 : tree.level_of(vertices.back());
    level_end_.clear();
    for (int level = 0; level <= finest; ++level) {
        const auto end = std::lower_bound(vertices.begin(), vertices.end(), VertexId(static_cast<std::int64_t>(tree.vertex_count(level))));
        level_end_.push_back(static_cast<std::size_t>(end - vertices.begin()));
    }
    diagonal_.assign(level_end_.size() - 1, {});
    for (std::size_t l = 0; l + 1 < level_end_.size(); ++l) diagonal_[l].assign(level_end_[l], {});
    add_level_diagonals(front, materials);
    ENSURE(level_end_[0] == tree.vertex_count(0), "every root vertex is a node of the front");
    rigid_.build(tree, materials, pinned);
    root_.resize(tree.vertex_count(0));
}

/// A tet of the finest linear mesh under the front (its active tets; for order 2 their children) counts in the levels
/// from its own up; each of its ancestors in its own level only.
void Multilevel::add_level_diagonals(const Front& front, const TetMaterials& materials) {
    const TetTree& tree = front.tree();
    const auto levels = static_cast<int>(diagonal_.size());
    const auto add = [&](TetId t, int from, int to) {
        if (from >= std::min(to, levels)) return;
        const auto& corner = tree.corners(t);
        const auto g = barycentric_gradients({tree.rest(corner[0]), tree.rest(corner[1]), tree.rest(corner[2]), tree.rest(corner[3])});
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            Vec3 gradient;
            if (k < 3) {
                gradient = Vec3(g(static_cast<int>(k), 0), g(static_cast<int>(k), 1), g(static_cast<int>(k), 2));
                sum += gradient;
            } else {
                gradient = -sum;
            }
            const VertexId v = corner[(k + 1) % 4];  // rows of g belong to corners 1, 2, 3; then corner 0
            const double stiffness = tree.volume(t) * mean_stiffness(materials.elasticity[t], gradient);
            const double mass = tree.volume(t) * materials.density[t] / 10;
            const double damping = (materials.mass_damping.empty() ? 0 : materials.mass_damping[t] * mass) +
                                   (materials.stiffness_damping.empty() ? 0 : materials.stiffness_damping[t] * stiffness);
            for (int l = from; l < std::min(to, levels); ++l) {
                Diagonal& d = diagonal_[static_cast<std::size_t>(l)][static_cast<std::size_t>(slot_[v])];
                d.stiffness += stiffness;
                d.mass += mass;
                d.damping += damping;
            }
        }
    };
    std::vector<TetId> generation;
    for (TetId t : front.active()) {
        const int level = tree.level_of(t);
        if (front.order() == 1) {
            add(t, level, levels);
        } else {
            add(t, level, level + 1);
            for (TetId c : tree.children(t)) add(c, level + 1, levels);
        }
        if (!tree.is_root(t) && (generation.empty() || generation.back() != tree.parent(t))) generation.push_back(tree.parent(t));
    }
    while (!generation.empty()) {
        std::vector<TetId> parents;
        for (TetId t : generation) {
            add(t, tree.level_of(t), tree.level_of(t) + 1);
            if (!tree.is_root(t)) parents.push_back(tree.parent(t));
        }
        std::sort(parents.begin(), parents.end());
        parents.erase(std::unique(parents.begin(), parents.end()), parents.end());
        generation = std::move(parents);
    }
}

void Multilevel::restrict_level(std::size_t l) const {
    for (std::size_t s = level_end_[l]; s-- > level_end_[l - 1];) {
        const Vec3 half = 0.5 * fine_[s];
        fine_[static_cast<std::size_t>(ends_[s][0])] += half;
        fine_[static_cast<std::size_t>(ends_[s][1])] += half;
    }
}

void Multilevel::update(const BlockMatrix& matrix, const Update& u) {
    const PerVertex<Vec3>* points = u.points;
    jacobi_.build(matrix);
    with_rigid_ = !rigid_.empty() && !u.contacts;
    if (with_rigid_) rigid_.update(u.stiffness_scale, u.mass_scale, u.damping_scale, u.x);
    inverse_.resize(diagonal_.size());
    coarse_.resize(diagonal_.size());
    fine_.resize(ends_.size());
    for (std::size_t s = 0; s < fine_.size(); ++s) fine_[s] = points != nullptr ? (*points)[vertices_[s]] : Vec3(Vec3::Zero());
    for (std::size_t l = diagonal_.size(); l-- > 0;) {
        if (points != nullptr) restrict_level(l + 1);
        inverse_[l].resize(diagonal_[l].size());
        coarse_[l].resize(diagonal_[l].size());
        for (std::size_t s = 0; s < diagonal_[l].size(); ++s) {
            const double d = u.stiffness_scale * diagonal_[l][s].stiffness + u.mass_scale * diagonal_[l][s].mass +
                             u.damping_scale * diagonal_[l][s].damping;
            inverse_[l][s] = fixed_[s] || !(d > 0) ? Vec3(Vec3::Zero()) : (fine_[s].array() + d).inverse().matrix();
        }
    }
}

void Multilevel::apply(const DofVector& r, DofVector& z) const {
    jacobi_.apply(r, z);
    if (diagonal_.empty() && !with_rigid_) return;
    for (std::size_t s = 0; s < fine_.size(); ++s) fine_[s] = dof_[s] >= 0 ? r[static_cast<std::size_t>(dof_[s])] : Vec3(Vec3::Zero());
    for (std::size_t l = diagonal_.size(); l-- > 0;) {
        restrict_level(l + 1);
        for (std::size_t s = 0; s < level_end_[l]; ++s) coarse_[l][s] = inverse_[l][s].cwiseProduct(fine_[s]);
    }
    if (with_rigid_) rigid_.apply(fine_, root_);
    DofVector& y = fine_;
    for (std::size_t s = 0; s < level_end_[0]; ++s) {
        y[s] = diagonal_.empty() ? Vec3(Vec3::Zero()) : coarse_[0][s];
        if (with_rigid_) y[s] += root_[s];
    }
    for (std::size_t l = 1; l < level_end_.size(); ++l) {
        for (std::size_t s = level_end_[l - 1]; s < level_end_[l]; ++s)
            y[s] = 0.5 * (y[static_cast<std::size_t>(ends_[s][0])] + y[static_cast<std::size_t>(ends_[s][1])]);
        if (l == diagonal_.size()) break;
        for (std::size_t s = 0; s < level_end_[l]; ++s) y[s] += coarse_[l][s];
    }
    for (std::size_t s = 0; s < y.size(); ++s)
        if (dof_[s] >= 0) z[static_cast<std::size_t>(dof_[s])] += y[s];
}

}  // namespace tetfront
