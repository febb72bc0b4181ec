#pragma once
// Writes a file completely or not at all: into a temporary file beside it, which then takes its name.
//
//     prepare_directory("frames");               // before the long work
//     check_writable("out.json");
//     write_atomically("out.json", text);

#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace tetfront {

/// Output that cannot be written: disk full, no permission, no directory. what(): one line with the file's name.
struct OutputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Whether the bytes must have reached the disk, so that even a power failure leaves the old file or the new one.
/// For many small files that can be made again it costs more than it is worth.
enum class Durable { yes, no };

/// Throws OutputError when a file of this name could not be written, or is a device or a pipe.
void check_writable(const std::filesystem::path& file);

/// Throws OutputError; then an old file of this name is still whole, and no temporary file is left. A process that is
/// killed meanwhile leaves "<file>.XXXXXX" with six letters or digits.
void write_atomically(const std::filesystem::path& file, std::string_view bytes, Durable durable = Durable::yes);

/// Makes the directory if needed and proves that files can be written there. Throws OutputError.
void prepare_directory(const std::filesystem::path& directory);

}  // namespace tetfront
