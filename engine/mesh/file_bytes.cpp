#include "engine/mesh/file_bytes.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace tetfront {

void check_readable(const std::filesystem::path& file, std::uintmax_t max_size) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) throw InputError{file.string(), "", "does not exist", "check the path"};
    if (!std::filesystem::is_regular_file(status))
        throw InputError{file.string(), "", "is not a file", "name a regular file"};
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw InputError{file.string(), "", "cannot be read: " + error.message(), ""};
    if (size == 0) throw InputError{file.string(), "", "is empty", "make it again"};
    if (size > max_size)
        throw InputError{file.string(), "", "has " + std::to_string(size >> 20) + " MiB",
                         "files up to " + std::to_string(max_size >> 20) + " MiB are read: simplify the mesh"};
    if (!std::ifstream(file, std::ios::binary))
        throw InputError{file.string(), "", "cannot be opened", "check its permissions"};
}

std::string read_bytes(const std::filesystem::path& file, std::uintmax_t max_size, std::uintmax_t at_most) {
    check_readable(file, max_size);
    std::string bytes(static_cast<std::size_t>(std::min(std::filesystem::file_size(file), at_most)), '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (static_cast<std::size_t>(in.gcount()) != bytes.size())
        throw InputError{file.string(), "", "could be read only in part", "check the disk"};
    return bytes;
}

}  // namespace tetfront
