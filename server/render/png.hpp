#pragma once
// PNG files: written whole or not at all, with what made them in their text chunks.
//
//     std::string bytes = encode_png(image, {.level = 1, .text = {{"Software", "tetfront 0.1"}, {"Scene", "bunny"}}});
//     write_file("frames/000000.png", bytes);        // temporary name, then renamed

#include "server/render/image.hpp"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetfront {

/// A file that cannot be written: disk full, no permission, no directory. what(): one line, with the file's name.
struct WriteError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct PngOptions {
    int level = 1;                                          // of zlib, 0..9; 1 is 2-4 times faster than 6
    std::vector<std::pair<std::string, std::string>> text;  // keyword (1..79 Latin letters) and UTF-8 text
};

/// The PNG file's bytes: 8-bit RGB or RGBA, sRGB chunk, filter SUB. Same input, same bytes.
std::string encode_png(const Image& image, const PngOptions& options);

/// Throws WriteError; then there is neither a half-written nor a temporary file, and an old one is still whole.
void write_file(const std::filesystem::path& file, std::string_view bytes);

/// Makes the directory if needed and proves that files can be written there. Throws WriteError.
void prepare_directory(const std::filesystem::path& directory);

}  // namespace tetfront
