#include "engine/mesh/tet_repair.hpp"

#include "engine/base/disjoint_sets.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace tetfront {

namespace {

/// Tets of each vertex, ascending.
struct VertexTets {
    explicit VertexTets(const TetMesh& mesh) : begin(mesh.positions.size() + 1, 0), tets(4 * mesh.corners.size()) {
        for (const auto& c : mesh.corners)
            for (VertexId v : c) ++begin[v.index() + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
        for (TetId t : ids<TetId>(mesh.corners.size()))
            for (VertexId v : mesh.corners[t]) tets[next[v.index()]++] = t;
    }
    std::vector<std::size_t> begin;  // [V+1]
    std::vector<TetId> tets;
};

/// Groups of `tets` that hang together by faces: those that share at least three vertices.
DisjointSets groups_by_faces(const TetMesh& mesh, const TetId* tets, std::size_t count) {
    DisjointSets sets(count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j) {
            const auto& a = mesh.corners[tets[i]];
            const auto& b = mesh.corners[tets[j]];
            const auto shared =
                std::count_if(a.begin(), a.end(), [&](VertexId v) { return std::ranges::count(b, v) > 0; });
            if (shared >= 3) sets.join(i, j);
        }
    return sets;
}

/// Worst angle of the four tets around the diagonal between the midpoints of corners 0-2 and 1-3, as its distance from
/// 0 or 180 degrees. The corner children have their parent's shape, and later generations bring no new shapes.
double refined_quality(const TetMesh& mesh, const std::array<VertexId, 4>& c) {
    const auto middle = [&](std::size_t i, std::size_t j) -> Vec3 {
        return (mesh.positions[c[i]] + mesh.positions[c[j]]) / 2;
    };
    const std::array<Vec3, 4> ring = {middle(0, 1), middle(1, 2), middle(2, 3), middle(3, 0)};
    double worst = 180;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto [low, high] = dihedral_range(middle(0, 2), middle(1, 3), ring[i], ring[(i + 1) % 4]);
        worst = std::min({worst, low, 180 - high});
    }
    return worst;
}

}  // namespace

std::size_t separate_pinches(TetMesh& mesh) {
    const VertexTets around(mesh);
    const std::size_t before = mesh.positions.size();
    // Groups are formed on the original mesh: separating one vertex does not change who shares a face with whom.
    const TetMesh original = mesh;
    for (VertexId v : ids<VertexId>(before)) {
        const TetId* tets = around.tets.data() + around.begin[v.index()];
        const std::size_t count = around.begin[v.index() + 1] - around.begin[v.index()];
        DisjointSets sets = groups_by_faces(original, tets, count);
        std::vector<VertexId> copy(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t group = sets.find(i);
            if (group == 0) continue;
            if (group == i) {
                copy[i] = VertexId(static_cast<std::int64_t>(mesh.positions.size()));
                mesh.positions.push_back(Vec3(original.positions[v]));
            }
            for (VertexId& corner : mesh.corners[tets[i]])
                if (corner == v) corner = copy[group];
        }
    }
    return mesh.positions.size() - before;
}

std::size_t count_pinched_edges(const TetMesh& mesh) {
    const VertexTets around(mesh);
    std::size_t pinched = 0;
    std::vector<VertexId> others;
    std::vector<TetId> fan;
    for (VertexId v : ids<VertexId>(mesh.positions.size())) {
        others.clear();
        const auto begin = around.tets.begin() + static_cast<std::ptrdiff_t>(around.begin[v.index()]);
        const auto end = around.tets.begin() + static_cast<std::ptrdiff_t>(around.begin[v.index() + 1]);
        for (auto t = begin; t != end; ++t)
            for (VertexId w : mesh.corners[*t])
                if (v < w) others.push_back(w);
        std::sort(others.begin(), others.end());
        others.erase(std::unique(others.begin(), others.end()), others.end());
        for (VertexId w : others) {
            fan.clear();
            std::copy_if(begin, end, std::back_inserter(fan),
                         [&](TetId t) { return std::ranges::count(mesh.corners[t], w) > 0; });
            DisjointSets sets = groups_by_faces(mesh, fan.data(), fan.size());
            for (std::size_t i = 1; i < fan.size(); ++i)
                if (sets.find(i) != 0) {
                    ++pinched;
                    break;
                }
        }
    }
    return pinched;
}

PerTet<std::int32_t> connected_pieces(const TetMesh& mesh) {
    std::vector<std::pair<std::array<VertexId, 3>, std::size_t>> faces;
    faces.reserve(4 * mesh.corners.size());
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        auto c = mesh.corners[t];
        std::sort(c.begin(), c.end());
        for (const auto& face :
             {std::array{c[1], c[2], c[3]}, {c[0], c[2], c[3]}, {c[0], c[1], c[3]}, {c[0], c[1], c[2]}})
            faces.emplace_back(face, t.index());
    }
    std::sort(faces.begin(), faces.end());
    DisjointSets sets(mesh.corners.size());
    for (std::size_t i = 1; i < faces.size(); ++i)
        if (faces[i].first == faces[i - 1].first) sets.join(faces[i].second, faces[i - 1].second);
    PerTet<std::int32_t> piece(mesh.corners.size(), -1);
    std::int32_t pieces = 0;
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        const std::size_t first = sets.find(t.index());
        piece[t] = first == t.index() ? pieces++ : piece[TetId(static_cast<std::int64_t>(first))];
    }
    return piece;
}

TetMesh keep_tets(const TetMesh& mesh, const std::function<bool(TetId)>& keep) {
    TetMesh kept;
    PerVertex<VertexId> compact(mesh.positions.size());
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        if (!keep(t)) continue;
        kept.corners.push_back(mesh.corners[t]);
        if (!mesh.region.empty()) kept.region.push_back(mesh.region[t]);
        for (VertexId v : mesh.corners[t]) compact[v] = VertexId{0};
    }
    for (VertexId v : ids<VertexId>(mesh.positions.size())) {
        if (!compact[v].valid()) continue;
        compact[v] = VertexId(static_cast<std::int64_t>(kept.positions.size()));
        kept.positions.push_back(mesh.positions[v]);
    }
    for (auto& corners : kept.corners)
        for (VertexId& v : corners) v = compact[v];
    return kept;
}

void order_for_refinement(TetMesh& mesh) {
    for (auto& c : mesh.corners) {
        // All turn three corners around: even permutations, the volume keeps its sign.
        const std::array<std::array<VertexId, 4>, 3> orders = {
            {{c[0], c[1], c[2], c[3]}, {c[0], c[3], c[1], c[2]}, {c[0], c[2], c[3], c[1]}}};
        std::array<double, 3> quality;
        for (std::size_t i = 0; i < 3; ++i) quality[i] = refined_quality(mesh, orders[i]);
        // Equal ones (up to rounding) go to the first.
        std::size_t best = 0;
        for (std::size_t i : {1, 2})
            if (quality[i] > quality[best] + 1e-9) best = i;
        c = orders[best];
    }
}

}  // namespace tetfront
