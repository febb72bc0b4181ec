#pragma once
// A small scene that builds in milliseconds: a soft beam that is held at one end.

#include "engine/scene/scene.hpp"

namespace tetfront {

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
