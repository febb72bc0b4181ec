#pragma once
// Frame + view -> pixels.
//
//     Renderer renderer;                                        // on the thread that will use it
//     Image image = renderer.render(*frame, view, "Bunny");     // RGB, rows top-down; RGBA if transparent
//
// The order of a picture: shadow map and floor, ambient occlusion, then tile by tile background, floor, surface, arrows
// and wireframe at supersampling x supersampling samples a pixel, averaged; title and legend last, at full sharpness.
// Same frame and view, same bytes.

#include "engine/simulation/frame.hpp"
#include "server/render/image.hpp"
#include "server/render/view.hpp"

#include <memory>
#include <string>

namespace tetfront {

class Renderer {
 public:
    /// Makes a GL context that belongs to this thread; make one Renderer per process. Throws InputError without OSMesa.
    Renderer();
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Throws InputError for a view out of range (see validate()) or when the legend's font is missing.
    Image render(const Frame& frame, const View& view, const std::string& title);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetfront
