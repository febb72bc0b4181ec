#include "engine/simulation/frame_builder.hpp"

#include <algorithm>

#include "engine/base/parallel.hpp"
#include "engine/material/material.hpp"

namespace tetfront {

namespace {

std::array<float, 3> to_float(const Vec3& p) {
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

/// Local nodes of the tets that a quadratic tet is cut into: the four at its corners and the octahedron between them.
constexpr std::array<std::array<std::size_t, 4>, 8> quadratic_pieces = {{
    {0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}, {5, 8, 4, 7}, {5, 8, 7, 9}, {5, 8, 9, 6}, {5, 8, 6, 4},
}};

/// Unique edges of the front and its pieces; the edges of quadratic tets are cut at their midpoints, which are nodes.
void add_edges_and_pieces(const Front& front, const ElasticityMatrices& matrices, FrameTopology& topology) {
    struct Edge {
        std::uint32_t a, b;
        std::uint8_t level;
    };
    const auto& vertices = front.vertices();
    const auto slot = [&](VertexId v) {
        return static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
    };
    std::vector<Edge> edges;
    edges.reserve(front.active().size() * (front.order() == 1 ? 6 : 12));
    for (TetId t : front.active()) {
        const auto level = static_cast<std::uint8_t>(front.tree().level_of(t));
        const auto node = front.nodes(t);
        std::array<std::uint32_t, 10> s{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(front.nodes_per_tet()); ++i) s[i] = slot(node[i]);
        const auto young = static_cast<float>(representative_young(matrices.elasticity[t]));
        const auto add_piece = [&](const std::array<std::size_t, 4>& local) {
            topology.pieces.push_back({s[local[0]], s[local[1]], s[local[2]], s[local[3]]});
            topology.piece_level.push_back(level);
            topology.piece_young.push_back(young);
        };
        if (front.order() == 1) add_piece({0, 1, 2, 3});
        else for (const auto& piece : quadratic_pieces) add_piece(piece);
        const auto add = [&](std::uint32_t a, std::uint32_t b) { edges.push_back({std::min(a, b), std::max(a, b), level}); };
        for (std::size_t e = 0; e < 6; ++e) {
            const auto a = s[static_cast<std::size_t>(tet_edges[e][0])], b = s[static_cast<std::size_t>(tet_edges[e][1])];
            if (front.order() == 1) {
                add(a, b);
            } else {
                add(a, s[4 + e]);
                add(s[4 + e], b);
            }
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        return std::tie(x.a, x.b, y.level) < std::tie(y.a, y.b, x.level);  // finest first
    });
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i > 0 && edges[i].a == edges[i - 1].a && edges[i].b == edges[i - 1].b) continue;
        topology.edges.push_back({edges[i].a, edges[i].b});
        topology.edge_level.push_back(edges[i].level);
    }
}

}  // namespace

FrontTets front_tets(const FrameTopology& topology) {
    std::size_t count = 0;
    for (const std::uint32_t n : topology.tets_by_level) count += n;
    const auto& pieces = topology.pieces;
    const bool quadratic = count > 0 && pieces.size() == quadratic_pieces.size() * count;
    if (!quadratic) return {pieces, topology.piece_level};
    FrontTets tets;
    tets.corners.reserve(count);
    tets.level.reserve(count);
    for (std::size_t i = 0; i < pieces.size(); i += quadratic_pieces.size()) {
        tets.corners.push_back({pieces[i][0], pieces[i + 1][1], pieces[i + 2][2], pieces[i + 3][3]});
        tets.level.push_back(topology.piece_level[i]);
    }
    return tets;
}

FrameBuilder::FrameBuilder(std::shared_ptr<const FrameModel> model, const Surface& surface, const ElasticityMatrices& matrices)
    : model_(std::move(model)), surface_(&surface), matrices_(&matrices) {}

void FrameBuilder::rebuild(const Front& front) {
    front_epoch_ = front.epoch();
    auto topology = std::make_shared<FrameTopology>();
    topology->epoch = ++epochs_made_;
    topology->tets_by_level.assign(static_cast<std::size_t>(front.tree().depth()) + 1, 0);
    for (TetId t : front.active()) ++topology->tets_by_level[static_cast<std::size_t>(front.tree().level_of(t))];
    const std::size_t count = surface_->attachment.size();
    points_.resize(count);
    topology->surface_level.resize(count);
    parallel_for(count, 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            points_[i] = front.locate(surface_->attachment[i].leaf, surface_->attachment[i].barycentric);
            topology->surface_level[i] = static_cast<std::uint8_t>(front.tree().level_of(points_[i].tet));
        }
    });
    add_edges_and_pieces(front, *matrices_, *topology);
    topology_ = std::move(topology);
}

std::shared_ptr<Frame> FrameBuilder::build(const Front& front, const PerVertex<Vec3>& x, FrameStatus status,
                                           std::vector<FramePull> pulls) {
    if (!topology_ || front_epoch_ != front.epoch()) rebuild(front);
    auto frame = std::make_shared<Frame>();
    frame->model = model_;
    frame->topology = topology_;
    frame->status = std::move(status);
    frame->pulls = std::move(pulls);
    frame->surface.resize(points_.size());
    const auto nodes = static_cast<std::size_t>(front.nodes_per_tet());
    parallel_for(points_.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Vec3 p = Vec3::Zero();
            for (std::size_t k = 0; k < nodes; ++k) p += points_[i].weights[k] * x[points_[i].nodes[k]];
            frame->surface[i] = to_float(p);
        }
    });
    frame->front_positions.reserve(front.vertices().size());
    for (VertexId v : front.vertices()) frame->front_positions.push_back(to_float(x[v]));
    return frame;
}

}  // namespace tetfront
