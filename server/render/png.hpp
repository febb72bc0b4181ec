#pragma once
// PNG files, with what made them in their text chunks.
//
//     std::string bytes = encode_png(image, {.level = 1, .text = {{"Software", "tetfront 0.1"}, {"Scene", "bunny"}}});
//     write_atomically("frames/000000.png", bytes, Durable::no);
//     read_png_text("frames/000000.png", "Scene")         // "bunny"

#include "server/render/image.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetfront {

struct PngOptions {
    int level = 1;                                          // of zlib, 0..9; 1 is 2-4 times faster than 6
    std::vector<std::pair<std::string, std::string>> text;  // keyword (1..79 Latin letters) and UTF-8 text
};

/// The PNG file's bytes: 8-bit RGB or RGBA, sRGB chunk, filter SUB. Same input, same bytes.
std::string encode_png(const Image& image, const PngOptions& options);

/// The text of the file's tEXt chunk with this keyword; empty when there is none or the file is no PNG.
std::string read_png_text(const std::filesystem::path& file, std::string_view keyword);

}  // namespace tetfront
