#pragma once
// The frame that the golden files hold. Its numbers are listed in tests/golden/README.md for the tests of the web
// client.

#include "engine/simulation/frame.hpp"

#include <memory>

namespace tetfront {

inline std::shared_ptr<Frame> sample_frame() {
    auto model = std::make_shared<FrameModel>();
    model->triangles = {{0, 1, 2}, {2, 3, 4}};
    model->young = {1e4F, 2e4F, 3e4F, 4e4F, 5e4F};
    model->young_range = {1e4F, 5e4F};
    model->depth = 2;
    model->up = 2;
    model->rest_box = {0, 0, 0, 1, 2, 4};

    auto topology = std::make_shared<FrameTopology>();
    topology->epoch = 7;
    topology->edges = {{0, 1}, {1, 2}, {0, 2}};
    topology->edge_level = {0, 1, 2};
    topology->surface_level = {0, 1, 2, 1, 0};
    topology->tets_by_level = {3, 16, 8};
    topology->pieces = {{0, 1, 2, 0}, {2, 1, 0, 2}};
    topology->piece_level = {1, 2};
    topology->piece_young = {1e4F, 2e4F};

    auto frame = std::make_shared<Frame>();
    frame->model = model;
    frame->topology = topology;
    frame->surface = {{-1, 0, 5}, {3, 8, 5}, {1, 4, 5}, {0, 2, 5}, {2, 6, 5}};
    frame->front_positions = {{-1, 0, 5}, {3, 0, 5}, {3, 8, 5}};
    frame->pulls = {{{1, 4, 5}, {1.5F, 4.25F, 6}, 12.5F}};
    frame->status = {.time = 1.25,
                     .step = 75,
                     .estimate = 0.015,
                     .tolerance = 0.02,
                     .step_milliseconds = 3.5,
                     .phases = {.adapt = 0.5, .setup = 0.25, .assemble = 1, .solve = 1.5, .other = 0.25},
                     .kinetic_energy = 2.5,
                     .elastic_energy = 1.25,
                     .steps_per_second = 60,
                     .free_vertices = 3,
                     .solver_iterations = 21,
                     .converged = true,
                     .warning = ""};
    return frame;
}

}  // namespace tetfront
