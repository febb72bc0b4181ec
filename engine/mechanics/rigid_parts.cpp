#include "engine/mechanics/rigid_parts.hpp"

#include <algorithm>
#include <limits>
#include <queue>

#include <Eigen/Cholesky>

#include "engine/base/parallel.hpp"
#include "engine/mechanics/element.hpp"

namespace tetfront {

namespace {

/// Edges of the root mesh: for each vertex its neighbours and how far they are.
struct Edges {
    struct To {
        std::uint32_t vertex;
        double length;
    };
    std::vector<std::uint32_t> begin;
    std::vector<To> to;

    explicit Edges(const TetTree& tree) {
        std::vector<std::array<std::uint32_t, 2>> pairs;
        for (TetId t : tree.level(0))
            for (const auto& edge : tet_edges)
                for (const std::size_t turn : {0U, 1U}) {
                    const auto end = [&](std::size_t e) { return static_cast<std::uint32_t>(tree.corners(t)[static_cast<std::size_t>(edge[e])].value); };
                    pairs.push_back({end(turn), end(1 - turn)});
                }
        std::sort(pairs.begin(), pairs.end());
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
        begin.assign(tree.vertex_count(0) + 1, 0);
        for (const auto& [from, at] : pairs) {
            ++begin[from + 1];
            to.push_back({at, (tree.rest(VertexId(from)) - tree.rest(VertexId(at))).norm()});
        }
        for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    }
};

/// Lowers distance[v] to that along edges from the source, where this is shorter and below `reach`; lists what it changed.
void spread(const Edges& edges, std::uint32_t source, double reach, std::vector<double>& distance, std::vector<std::uint32_t>& changed) {
    using Item = std::pair<double, std::uint32_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    changed.clear();
    distance[source] = 0;
    queue.emplace(0, source);
    while (!queue.empty()) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > distance[v]) continue;
        changed.push_back(v);
        for (std::uint32_t n = edges.begin[v]; n < edges.begin[v + 1]; ++n) {
            const auto& [next, length] = edges.to[n];
            if (d + length >= std::min(reach, distance[next])) continue;
            distance[next] = d + length;
            queue.emplace(d + length, next);
        }
    }
}

/// A part reaches so many times as far as the farthest vertex is from the middle of its nearest part.
constexpr double overlap = 1.5;
/// Keeps A definite where motions of parts depend on each other.
constexpr double regularisation = 1e-9;

}  // namespace

void RigidParts::build(const TetTree& tree, const TetMaterials& materials, const PerVertex<std::uint8_t>& pinned) {
    const std::size_t n = tree.vertex_count(0);
    const bool same = built_ && pinned_.size() == n && std::equal(pinned_.begin(), pinned_.end(), pinned.begin(),
                                                                 [](auto a, auto b) { return (a != 0) == (b != 0); });
    if (same) return;
    built_ = true;
    pinned_.assign(pinned.begin(), pinned.begin() + static_cast<std::ptrdiff_t>(n));
    parts_ = std::min(most, n / vertices_of_one);
    if (parts_ < 2) parts_ = 0;
    if (empty()) return;
    grow(tree);
    assemble(tree, materials);
    scales_ = {-1, -1, -1};
    rotation_.resize(n);
    turned_.resize(n);
    load_.resize(static_cast<Eigen::Index>(6 * parts_));
    move_.resize(static_cast<Eigen::Index>(6 * parts_));
}

void RigidParts::grow(const TetTree& tree) {
    const std::size_t n = tree.vertex_count(0);
    const Edges edges(tree);
    // Each middle is as far from the ones before as possible; other components are infinitely far.
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> middles, changed;
    for (std::uint32_t middle = 0; middles.size() < parts_;) {
        middles.push_back(middle);
        spread(edges, middle, std::numeric_limits<double>::infinity(), distance, changed);
        middle = static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
        if (distance[middle] == 0) break;
    }
    parts_ = middles.size();
    double farthest = 0;
    for (const double d : distance)
        if (std::isfinite(d)) farthest = std::max(farthest, d);
    const double reach = overlap * farthest;

    std::vector<std::vector<Weight>> of_vertex(n);
    std::vector<double> near(n, std::numeric_limits<double>::infinity());
    for (std::uint32_t part = 0; part < middles.size(); ++part) {
        spread(edges, middles[part], reach, near, changed);
        for (const std::uint32_t v : changed) {
            const double falloff = reach > 0 ? 1 - near[v] / reach : 1;
            of_vertex[v].push_back({part, falloff * falloff});
            near[v] = std::numeric_limits<double>::infinity();
        }
    }
    weights_.clear();
    weights_begin_.assign(1, 0);
    for (VertexId v : ids<VertexId>(n)) {
        double sum = 0;
        for (const Weight& w : of_vertex[v.index()]) sum += w.value;
        if (!pinned_[v])
            for (const Weight& w : of_vertex[v.index()]) weights_.push_back({w.part, w.value / sum});
        weights_begin_.push_back(static_cast<std::uint32_t>(weights_.size()));
    }
}

Eigen::Matrix<double, 3, 6> RigidParts::motion(VertexId v) const {
    const Vec3& a = arm_[v];
    Eigen::Matrix<double, 3, 6> d;
    d << 1, 0, 0, 0, a[2], -a[1],
         0, 1, 0, -a[2], 0, a[0],
         0, 0, 1, a[1], -a[0], 0;
    return d;
}

void RigidParts::assemble(const TetTree& tree, const TetMaterials& materials) {
    const std::size_t n = tree.vertex_count(0);
    Eigen::AlignedBox3d box;
    for (VertexId v : ids<VertexId>(n)) box.extend(tree.rest(v));
    arm_.resize(n);
    for (VertexId v : ids<VertexId>(n)) arm_[v] = (tree.rest(v) - box.center()) / box.diagonal().norm();

    const auto unknowns = static_cast<Eigen::Index>(6 * parts_);
    for (Eigen::MatrixXd* a : {&stiffness_, &mass_, &damping_}) a->setZero(unknowns, unknowns);
    roots_.clear();
    for (TetId t : tree.level(0)) {
        const auto& c = tree.corners(t);
        const auto g = barycentric_gradients({tree.rest(c[0]), tree.rest(c[1]), tree.rest(c[2]), tree.rest(c[3])});
        const double volume = tree.volume(t), mass = volume * materials.density[t];
        Root& root = roots_.emplace_back();
        root = {c, g, volume};

        const auto core = material_blocks(materials.elasticity[t].upper, g);
        std::array<std::array<Mat3, 4>, 4> block;  // of the stiffness, by corners
        for (auto& row : block) row.fill(Mat3::Zero());
        for (std::size_t k = 1; k < 4; ++k) {
            for (std::size_t l = 1; l < 4; ++l) {
                const Mat3 b = volume * Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(core[k - 1][l - 1].m.data());
                block[k][l] += b;
                block[0][l] -= b;
                block[k][0] -= b;
                block[0][0] += b;
            }
        }
        const double by_mass = materials.mass_damping.empty() ? 0 : materials.mass_damping[t];
        const double by_stiffness = materials.stiffness_damping.empty() ? 0 : materials.stiffness_damping[t];
        for (std::size_t k = 0; k < 4; ++k) {
            const VertexId v = root.corner[k];
            for (std::size_t l = 0; l < 4; ++l) {
                const VertexId w = root.corner[l];
                const Eigen::Matrix<double, 3, 6> dv = motion(v), dw = motion(w);
                const Mat6 stiff = dv.transpose() * block[k][l] * dw, heavy = mass * ElementOrder<1>::mass(static_cast<int>(k), static_cast<int>(l)) * dv.transpose() * dw;
                const Mat6 damp = by_mass * heavy + by_stiffness * stiff;
                for (std::uint32_t i = weights_begin_[v.index()]; i < weights_begin_[v.index() + 1]; ++i) {
                    for (std::uint32_t j = weights_begin_[w.index()]; j < weights_begin_[w.index() + 1]; ++j) {
                        const double weight = weights_[i].value * weights_[j].value;
                        const Eigen::Index row = 6 * weights_[i].part, column = 6 * weights_[j].part;
                        stiffness_.block<6, 6>(row, column) += weight * stiff;
                        mass_.block<6, 6>(row, column) += weight * heavy;
                        if (materials.damped()) damping_.block<6, 6>(row, column) += weight * damp;
                    }
                }
            }
        }
    }
}

void RigidParts::update(double stiffness_scale, double mass_scale, double damping_scale, const PerVertex<Vec3>& x) {
    if (scales_ != std::array{stiffness_scale, mass_scale, damping_scale}) {
        scales_ = {stiffness_scale, mass_scale, damping_scale};
        Eigen::MatrixXd a = stiffness_scale * stiffness_ + mass_scale * mass_ + damping_scale * damping_;
        for (Eigen::Index i = 0; i < a.rows(); ++i) a(i, i) = a(i, i) > 0 ? (1 + regularisation) * a(i, i) : 1;
        const Eigen::MatrixXd inverse = a.llt().solve(Eigen::MatrixXd::Identity(a.rows(), a.rows()));
        inverse_ = 0.5 * (inverse + inverse.transpose());
    }
    for (Mat3& f : turned_) f.setZero();
    for (const Root& root : roots_) {
        const Vec3& x0 = x[root.corner[0]];
        Mat3 f = Mat3::Zero();
        for (std::size_t k = 1; k < 4; ++k)
            for (int c = 0; c < 3; ++c)
                f.col(c) += root.gradient(static_cast<int>(k) - 1, c) * (x[root.corner[k]] - x0);
        for (const VertexId v : root.corner) turned_[v] += root.volume * f;
    }
    parallel_for(rotation_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (VertexId v : ids<VertexId>(static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end))) {
            M3<double> f;
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> view(f.m.data());
            view = turned_[v] / std::max(turned_[v].norm(), 1e-300);
            const Svd3<double> d = svd3(f);
            f = mul_bt(d.u, d.v);
            rotation_[v] = view;
        }
    });
}

void RigidParts::apply(const DofVector& r, DofVector& z) const {
    load_.setZero();
    for (VertexId v : ids<VertexId>(rotation_.size())) {
        const Vec3 local = rotation_[v].transpose() * r[v.index()];
        Vec6 load;
        load << local, arm_[v].cross(local);
        for (std::uint32_t i = weights_begin_[v.index()]; i < weights_begin_[v.index() + 1]; ++i)
            load_.segment<6>(6 * weights_[i].part) += weights_[i].value * load;
    }
    move_.noalias() = inverse_ * load_;
    for (VertexId v : ids<VertexId>(rotation_.size())) {
        Vec6 move = Vec6::Zero();
        for (std::uint32_t i = weights_begin_[v.index()]; i < weights_begin_[v.index() + 1]; ++i)
            move += weights_[i].value * move_.segment<6>(6 * weights_[i].part);
        z[v.index()] = rotation_[v] * (move.head<3>() + move.tail<3>().cross(arm_[v]));
    }
}

}  // namespace tetfront
