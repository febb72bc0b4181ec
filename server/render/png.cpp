#include "server/render/png.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <png.h>
#include <unistd.h>

namespace tetfront {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw WriteError(file.string() + ": cannot be written: " + std::generic_category().message(error));
}

[[noreturn]] void on_error(png_structp, png_const_charp message) {
    throw LogicError(std::string("libpng: ") + message);
}
void on_warning(png_structp, png_const_charp) {}
void append(png_structp png, png_bytep data, std::size_t length) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), length);
}
void flush(png_structp) {}

/// libpng's state, freed however encode_png ends. Errors are exceptions that pass through libpng's frames.
struct Writer {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;

    Writer() { ENSURE(png && info, "libpng does not start"); }
    ~Writer() { png_destroy_write_struct(&png, &info); }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;
};

/// Keeps the name only once the file is complete.
class TemporaryFile {
 public:
    explicit TemporaryFile(const std::filesystem::path& target)
        : target_(target), name_(target.string() + "." + std::to_string(::getpid()) + ".part") {
        descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (descriptor_ < 0) fail(target_, errno);
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

std::string encode_png(const Image& image, const PngOptions& options) {
    ENSURE(image.channels == 3 || image.channels == 4, image.channels, " channels");
    std::string bytes;
    bytes.reserve(image.pixels.size() / 8);
    Writer writer;
    png_structp png = writer.png;
    png_infop info = writer.info;
    png_set_write_fn(png, &bytes, append, flush);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
                 image.channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, std::clamp(options.level, 0, 9));
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    std::vector<png_text> chunks;
    for (const auto& [keyword, text] : options.text) {
        const bool ascii = std::ranges::all_of(text, [](unsigned char c) { return c < 0x80; });
        png_text chunk{};
        chunk.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        chunk.key = const_cast<char*>(keyword.c_str());  // libpng copies, its struct is older than const
        chunk.text = const_cast<char*>(text.c_str());
        chunk.text_length = ascii ? text.size() : 0;
        chunk.itxt_length = ascii ? 0 : text.size();
        chunks.push_back(chunk);
    }
    if (!chunks.empty()) png_set_text(png, info, chunks.data(), static_cast<int>(chunks.size()));
    png_write_info(png, info);
    for (int y = 0; y < image.height; ++y) png_write_row(png, image.pixel(0, y));
    png_write_end(png, info);
    return bytes;
}

void write_file(const std::filesystem::path& file, std::string_view bytes) {
    TemporaryFile temporary(file);
    temporary.write(bytes);
    temporary.rename();
}

void prepare_directory(const std::filesystem::path& directory) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) throw WriteError(directory.string() + ": cannot be made: " + error.message());
    const std::filesystem::path probe = directory / ("probe." + std::to_string(::getpid()));
    const int descriptor = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) fail(directory, errno);
    ::close(descriptor);
    ::unlink(probe.c_str());
}

}  // namespace tetfront
