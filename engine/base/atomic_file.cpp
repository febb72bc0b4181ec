#include "engine/base/atomic_file.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

namespace tetfront {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw OutputError(file.string() + ": cannot be written: " + std::generic_category().message(error));
}

/// The process's umask can only be read by setting it: once, before any other thread makes files.
mode_t mask() {
    static const mode_t value = [] {
        const mode_t current = ::umask(022);
        ::umask(current);
        return current;
    }();
    return value;
}

/// An open temporary file beside `target`; removed unless it has been renamed.
class TemporaryFile {
 public:
    explicit TemporaryFile(const std::filesystem::path& target) : target_(target), name_(target.string() + ".XXXXXX") {
        std::error_code error;
        const std::filesystem::file_status status = std::filesystem::status(target, error);
        if (std::filesystem::is_directory(status)) fail(target, EISDIR);
        // A rename would replace a device or a pipe by a file: as root also /dev/null.
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) fail(target, EINVAL);
        if (std::filesystem::is_symlink(target, error)) {  // keep the link, replace what it names
            target_ = std::filesystem::weakly_canonical(target, error);
            if (error) fail(target, error.value());
            name_ = target_.string() + ".XXXXXX";
        }
        descriptor_ = mkstemp(name_.data());
        if (descriptor_ < 0) fail(target, errno);
    }
    ~TemporaryFile() {
        if (descriptor_ >= 0) ::close(descriptor_);
        if (!renamed_) ::unlink(name_.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    void write(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) fail(target_, errno);
            bytes.remove_prefix(static_cast<std::size_t>(written));
        }
    }
    void rename(Durable durable) {
        if (::fchmod(descriptor_, 0666 & ~mask()) != 0) fail(target_, errno);  // mkstemp made it private
        if (durable == Durable::yes && ::fsync(descriptor_) != 0) fail(target_, errno);
        // Some file systems report a full disk or quota only here.
        if (::close(std::exchange(descriptor_, -1)) != 0) fail(target_, errno);
        if (::rename(name_.c_str(), target_.c_str()) != 0) fail(target_, errno);
        renamed_ = true;
    }

 private:
    std::filesystem::path target_;
    std::string name_;
    int descriptor_ = -1;
    bool renamed_ = false;
};

}  // namespace

void check_writable(const std::filesystem::path& file) { const TemporaryFile probe(file); }

void write_atomically(const std::filesystem::path& file, std::string_view bytes, Durable durable) {
    TemporaryFile temporary(file);
    temporary.write(bytes);
    temporary.rename(durable);
}

void prepare_directory(const std::filesystem::path& directory) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) throw OutputError(directory.string() + ": cannot be made: " + error.message());
    std::string probe = (directory / "probe.XXXXXX").string();
    const int descriptor = ::mkstemp(probe.data());
    if (descriptor < 0) fail(directory, errno);
    ::close(descriptor);
    ::unlink(probe.c_str());
}

}  // namespace tetfront
