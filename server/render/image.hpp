#pragma once
// Pixels in memory: 8 bits a channel, sRGB-encoded, rows top-down without padding.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetfront {

struct Image {
    int width = 0, height = 0;
    int channels = 3;                  // 3: RGB, 4: RGBA with straight (not premultiplied) alpha
    std::vector<std::uint8_t> pixels;  // [height * width * channels]

    Image() = default;
    Image(int width_, int height_, int channels_)
        : width(width_),
          height(height_),
          channels(channels_),
          pixels(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) *
                 static_cast<std::size_t>(channels_)) {}

    [[nodiscard]] std::uint8_t* pixel(int x, int y) { return pixels.data() + offset(x, y); }
    [[nodiscard]] const std::uint8_t* pixel(int x, int y) const { return pixels.data() + offset(x, y); }

 private:
    [[nodiscard]] std::size_t offset(int x, int y) const {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
};

}  // namespace tetfront
