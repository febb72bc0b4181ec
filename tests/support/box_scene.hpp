#pragma once
// A small scene that builds in milliseconds: a soft beam that is held at one end.

#include "engine/scene/scene.hpp"

namespace tetfront {

/// Such a beam as a file, for the program.
inline constexpr const char* box_scene_text = R"({
  "schema_version": 1, "title": "A beam", "up": "z",
  "mesh": {"box": {"low": [0, 0, 0], "high": [4, 1, 1], "cells": [4, 1, 1]}},
  "levels": 1,
  "material": {"density": 1000, "poisson": 0.3, "young": 1e5},
  "pins": [{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}]
})";

inline Scene box_scene() {
    Scene scene;
    scene.name = "beam";
    scene.title = "A beam for tests";
    scene.mesh = BoxMeshSpec{{0, 0, 0}, {4, 1, 1}, {4, 1, 1}};
    scene.levels = 1;
    scene.pins = {Box{{-0.1, -0.1, -0.1}, {0.01, 1.1, 1.1}}};
    scene.material.materials[0].mass_damping = 1.0;
    return scene;
}

}  // namespace tetfront
