#include "server/cli/atomic_file.hpp"

#include "server/cli/commands.hpp"

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

namespace tetfront {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw OutputError(file.string() + ": cannot be written: " + std::generic_category().message(error));
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
    void rename() {
        const mode_t mask = ::umask(0);  // mkstemp made it private
        ::umask(mask);
        if (::fchmod(descriptor_, 0666 & ~mask) != 0 || ::fsync(descriptor_) != 0) fail(target_, errno);
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

void write_atomically(const std::filesystem::path& file, std::string_view bytes) {
    TemporaryFile temporary(file);
    temporary.write(bytes);
    temporary.rename();
}

}  // namespace tetfront
