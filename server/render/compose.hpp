#pragma once
// Samples over a backdrop -> pixels of a picture.
//
//     compose(tile, backdrop, {part, 2, samples}, image);
//
// Rows of the tile, the backdrop and the samples count from the bottom, as GL reads them; those of the image from the
// top. Colours are sRGB-encoded with premultiplied alpha; what goes into an image with alpha is made straight.

#include "server/render/image.hpp"
#include "server/render/view.hpp"

#include <cstdint>
#include <span>

namespace tetfront {

/// What lies over the backdrop: n x n samples for each pixel of `part`, a part of the tile.
struct Samples {
    PixelBox part;  // of the picture
    int per_side = 1;
    std::span<const std::uint8_t> rgba;  // [part.height * n][part.width * n][4]
};

/// tile: part of the picture that is filled. backdrop: [tile.height][tile.width] RGBA.
void compose(const PixelBox& tile, std::span<const std::uint8_t> backdrop, const Samples& samples, Image& image);

}  // namespace tetfront
