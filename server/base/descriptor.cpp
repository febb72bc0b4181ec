#include "server/base/descriptor.hpp"

#include "engine/base/atomic_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace tetfront {

namespace {
int checked(int result, const char* what) {
    if (result < 0) throw OutputError(std::string(what) + " cannot be made: " + std::generic_category().message(errno));
    return result;
}
}  // namespace

void Descriptor::close() {
    if (number_ >= 0) ::close(release());
}

Pipe make_pipe() {
    std::array<int, 2> ends{};
    checked(::pipe2(ends.data(), O_CLOEXEC), "a pipe");
    return {Descriptor(ends[0]), Descriptor(ends[1])};
}

Descriptor open_null() { return Descriptor(checked(::open("/dev/null", O_RDWR | O_CLOEXEC), "a way to /dev/null")); }

Descriptor make_buffer() { return Descriptor(checked(::memfd_create("tetfront", MFD_CLOEXEC), "a file in memory")); }

int write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
}

std::string read_end(int descriptor, std::size_t most) {
    const off_t size = std::max<off_t>(::lseek(descriptor, 0, SEEK_END), 0);
    std::string text(std::min(most, static_cast<std::size_t>(size)), '\0');
    const ssize_t read = ::pread(descriptor, text.data(), text.size(), size - static_cast<off_t>(text.size()));
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
    return text;
}

}  // namespace tetfront
