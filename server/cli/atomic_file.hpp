#pragma once
// Writes a file completely or not at all: into a temporary file beside it, which then takes its name.
//
//     check_writable("out.json");                // before the long work
//     write_atomically("out.json", text);

#include <filesystem>
#include <string_view>

namespace tetfront {

/// Throws OutputError when a file of this name could not be written, or is a device or a pipe.
void check_writable(const std::filesystem::path& file);

/// Throws OutputError; then an old file of this name is still whole.
void write_atomically(const std::filesystem::path& file, std::string_view bytes);

}  // namespace tetfront
