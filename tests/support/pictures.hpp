#pragma once
// Pictures in tests: read a PNG, compare two images, hold one against a golden file.

#include "engine/base/atomic_file.hpp"
#include "server/render/image.hpp"
#include "server/render/png.hpp"
#include "tests/support/project.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <png.h>

namespace tetfront {

inline Image read_png(const std::filesystem::path& file) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(&png, file.c_str())) throw std::runtime_error(file.string() + png.message);
    png.format = (png.format & PNG_FORMAT_FLAG_ALPHA) ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height), png.format == PNG_FORMAT_RGBA ? 4 : 3);
    if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr))
        throw std::runtime_error(file.string() + png.message);
    return image;
}

/// Share of the pixels of which a channel differs by more than `tolerance`; 1 for images of different shape.
inline double share_different(const Image& a, const Image& b, int tolerance) {
    if (a.width != b.width || a.height != b.height || a.channels != b.channels) return 1;
    int different = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            bool differs = false;
            for (int c = 0; c < a.channels; ++c)
                differs = differs || std::abs(a.pixel(x, y)[c] - b.pixel(x, y)[c]) > tolerance;
            different += differs;
        }
    }
    return static_cast<double>(different) / (a.width * a.height);
}

/// The same picture but for what another build of the rasteriser may round: 2/255 on 99.5 % of the pixels, and no more
/// than one pixel in a thousand (of an edge) clearly different.
inline bool same_picture(const Image& a, const Image& b) {
    return share_different(a, b, 2) <= 0.005 && share_different(a, b, 40) <= 0.001;
}

inline std::filesystem::path golden_picture(const std::string& name) {
    return source_folder() / "tests" / "golden" / name;
}

/// TETFRONT_UPDATE_GOLDEN=1 writes the file anew; look at it before committing it. A difference leaves the new picture
/// in the temporary directory.
inline void expect_golden_picture(const std::string& name, const Image& image) {
    if (std::getenv("TETFRONT_UPDATE_GOLDEN")) return write_atomically(golden_picture(name), encode_png(image, {.level = 9, .text = {}}));
    const Image golden = read_png(golden_picture(name));
    if (same_picture(golden, image)) return;
    const auto seen = std::filesystem::temp_directory_path() / ("tetfront-" + name);
    write_atomically(seen, encode_png(image, {}));
    ADD_FAILURE() << name << ": " << 100 * share_different(golden, image, 2)
                  << " % of the pixels differ by more than 2, " << 100 * share_different(golden, image, 40)
                  << " % by more than 40; see " << seen;
}

}  // namespace tetfront
