#include "server/render/png.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include <png.h>

namespace tetfront {

namespace {

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

std::string read_png_text(const std::filesystem::path& file, std::string_view keyword) {
    std::ifstream in(file, std::ios::binary);
    std::array<char, 8> signature{};
    if (!in.read(signature.data(), signature.size()) || signature[1] != 'P') return "";
    for (std::array<unsigned char, 8> header{}; in.read(reinterpret_cast<char*>(header.data()), header.size());) {
        const std::size_t length =
            std::size_t{header[0]} << 24 | std::size_t{header[1]} << 16 | std::size_t{header[2]} << 8 | header[3];
        const std::string_view kind(reinterpret_cast<const char*>(header.data()) + 4, 4);
        if (kind == "IDAT") break;  // text of encode_png() comes before
        if (kind != "tEXt" || length > 100'000) {
            in.seekg(static_cast<std::streamoff>(length) + 4, std::ios::cur);
            continue;
        }
        std::string text(length + 4, '\0');  // with the checksum
        if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) break;
        text.resize(length);
        if (text.size() > keyword.size() && text[keyword.size()] == '\0' && text.starts_with(keyword))
            return text.substr(keyword.size() + 1);
    }
    return "";
}

}  // namespace tetfront
