#pragma once
// Small scenes for tests, from JSON text.

#include <memory>
#include <string>

#include "engine/simulation/simulation.hpp"

namespace tetfront::testing {

/// A box of 2 x 1 x 1 m with two levels, E 1e5, nothing pinned, no gravity; `overrides` as on the command line.
inline std::shared_ptr<const Model> box_model(const std::vector<Override>& overrides = {}) {
    static constexpr std::string_view text = R"({
        "schema_version": 1, "up": "z",
        "mesh": {"box": {"low": [0, 0, 0], "high": [2, 1, 1], "cells": [4, 2, 2]}},
        "levels": 2,
        "material": {"density": 1000, "poisson": 0.3, "young": 1e5},
        "gravity": [0, 0, 0]
    })";
    return build_model(parse_scene(text, "box", ".", overrides));
}

/// The same, clamped at x = 0, under gravity.
inline std::shared_ptr<const Model> cantilever_model(std::vector<Override> overrides = {}) {
    overrides.insert(overrides.begin(), {{"/pins", R"([{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}])"},
                                         {"/gravity", "[0, 0, -9.81]"}});
    return box_model(overrides);
}

/// The smallest model whose front changes, for whatever is done to it very often.
inline std::shared_ptr<const Model> snapshot_model() {
    return cantilever_model({{"/mesh/box/cells", "[1, 1, 1]"}, {"/front/tolerance", "0.001"}});
}

}  // namespace tetfront::testing
