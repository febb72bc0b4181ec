#pragma once
// A frame made by hand: a lump without any symmetry on three levels, with a stiffness that grows downwards, and a front
// that encloses it, with tets inside.
//
//     auto frame = blob_frame(24);              // 2 * 24 * 48 - 96 triangles

#include "engine/simulation/frame.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace tetfront {

/// rings >= 3: circles of latitude. up: axis. The lump is about 1 m wide and stands on height 0.
inline std::shared_ptr<Frame> blob_frame(int rings, int up = 2) {
    auto model = std::make_shared<FrameModel>();
    auto topology = std::make_shared<FrameTopology>();
    auto frame = std::make_shared<Frame>();
    const int sides = 2 * rings;
    const auto add = [&](std::vector<std::array<float, 3>>& to, double latitude, double longitude, double scale) {
        const double x = std::cos(latitude) * std::cos(longitude), y = std::cos(latitude) * std::sin(longitude);
        const double z = std::sin(latitude);
        // A nose to the right and an ear at the top left, seen from -y.
        const double nose = 0.55 * std::exp(-6 * ((x - 0.9) * (x - 0.9) + y * y + (z - 0.1) * (z - 0.1)));
        const double ear = 0.9 * std::exp(-14 * ((x + 0.5) * (x + 0.5) + y * y + (z - 0.85) * (z - 0.85)));
        const double r = scale * 0.4 * (1 + nose + ear);
        std::array<float, 3> p{};
        const auto axis = static_cast<std::size_t>(up);
        p[(axis + 1) % 3] = static_cast<float>(r * x);
        p[(axis + 2) % 3] = static_cast<float>(r * y);
        p[axis] = static_cast<float>(r * z + 0.4);
        to.push_back(p);
    };
    const auto grid = [&](std::vector<std::array<float, 3>>& to, int m, double scale) {
        add(to, -std::numbers::pi / 2, 0, scale);
        for (int i = 1; i < m; ++i) {
            for (int j = 0; j < 2 * m; ++j)
                add(to, std::numbers::pi * (static_cast<double>(i) / m - 0.5), std::numbers::pi * j / m, scale);
        }
        add(to, std::numbers::pi / 2, 0, scale);
    };
    grid(frame->surface, rings, 1);
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * sides + j % sides); };
    const auto top = static_cast<std::uint32_t>(frame->surface.size() - 1);
    for (int j = 0; j < sides; ++j) {
        model->triangles.push_back({0, at(1, j + 1), at(1, j)});
        model->triangles.push_back({top, at(rings - 1, j), at(rings - 1, j + 1)});
        for (int i = 1; i + 1 < rings; ++i) {
            model->triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            model->triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
    }
    std::array<float, 6> box = {1e9F, 1e9F, 1e9F, -1e9F, -1e9F, -1e9F};
    for (const auto& p : frame->surface) {
        for (std::size_t i = 0; i < 3; ++i) box[i] = std::min(box[i], p[i]), box[i + 3] = std::max(box[i + 3], p[i]);
        const float height = p[static_cast<std::size_t>(up)];
        topology->surface_level.push_back(height < 0.3F ? 0 : height < 0.6F ? 1 : 2);
        model->young.push_back(1e6F * std::pow(10.0F, -2 * height));
    }
    model->young_range = {1e4F, 1e6F};
    model->rest_box = box;
    model->up = up;
    model->depth = 2;

    constexpr int cage = 8;
    grid(frame->front_positions, cage, 1.04);
    for (int i = 1; i < cage; ++i) {
        for (int j = 0; j < 2 * cage; ++j) {
            const auto a = static_cast<std::uint32_t>(1 + (i - 1) * 2 * cage + j);
            const auto next = static_cast<std::uint32_t>(1 + (i - 1) * 2 * cage + (j + 1) % (2 * cage));
            topology->edges.push_back({a, next});
            topology->edge_level.push_back(static_cast<std::uint8_t>(i < 3 ? 0 : i < 6 ? 1 : 2));
            if (i + 1 == cage) continue;
            topology->edges.push_back({a, a + 2 * cage});
            topology->edge_level.push_back(static_cast<std::uint8_t>(i < 3 ? 0 : i < 6 ? 1 : 2));
        }
    }
    // Pieces: the cage's triangles and its middle span tets, whose inner halves are of level 0.
    const auto outer = static_cast<std::uint32_t>(frame->front_positions.size());
    grid(frame->front_positions, cage, 0.5);
    std::array<float, 3> middle{};
    middle[static_cast<std::size_t>(up)] = 0.4F;
    frame->front_positions.push_back(middle);
    const std::uint32_t centre = 2 * outer;
    const auto add_cone = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, int level) {
        const std::uint32_t d = a + outer, e = b + outer, f = c + outer;
        for (const auto& piece : {std::array{centre, d, e, f}, {a, b, c, d}, {b, c, d, e}, {c, d, e, f}}) {
            topology->pieces.push_back(piece);
            topology->piece_level.push_back(static_cast<std::uint8_t>(piece[0] == centre ? 0 : level));
            topology->piece_young.push_back(piece[0] == centre ? 1e6F : 1e5F);
        }
    };
    const auto on_cage = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * 2 * cage + j % (2 * cage)); };
    for (int j = 0; j < 2 * cage; ++j) {
        add_cone(0, on_cage(1, j), on_cage(1, j + 1), 1);
        add_cone(outer - 1, on_cage(cage - 1, j), on_cage(cage - 1, j + 1), 2);
        for (int i = 1; i + 1 < cage; ++i) {
            add_cone(on_cage(i, j), on_cage(i, j + 1), on_cage(i + 1, j + 1), i < 4 ? 1 : 2);
            add_cone(on_cage(i, j), on_cage(i + 1, j), on_cage(i + 1, j + 1), i < 4 ? 1 : 2);
        }
    }
    topology->epoch = 1;
    topology->tets_by_level = {312, 1208, 2304};
    frame->status.time = 1.25;
    frame->status.estimate = 0.0123;
    frame->model = model;
    frame->topology = topology;
    return frame;
}

}  // namespace tetfront
