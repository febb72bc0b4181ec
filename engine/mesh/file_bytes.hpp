#pragma once
// A whole file in memory, with every way in which that can fail said clearly.
//
//     std::string bytes = read_bytes("bunny.msh", std::uintmax_t{1} << 30);

#include <cstdint>
#include <filesystem>
#include <string>

namespace tetfront {

/// Throws InputError when the file does not exist, is no regular file, is empty, has more than `max_size` bytes, or
/// cannot be opened.
void check_readable(const std::filesystem::path& file, std::uintmax_t max_size);

/// The first `at_most` bytes of a file that check_readable() accepts. Throws InputError.
std::string read_bytes(const std::filesystem::path& file, std::uintmax_t max_size,
                       std::uintmax_t at_most = UINTMAX_MAX);

}  // namespace tetfront
