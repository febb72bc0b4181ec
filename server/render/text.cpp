#include "server/render/text.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>

#include <ft2build.h>

#include FT_FREETYPE_H

namespace tetfront {

namespace {

/// Where distributions put the DejaVu fonts.
constexpr const char* font_directories[] = {"/usr/share/fonts/truetype/dejavu/", "/usr/share/fonts/dejavu-sans-fonts/",
                                            "/usr/share/fonts/dejavu/", "/usr/share/fonts/TTF/",
                                            "/usr/local/share/fonts/"};

std::string find_font(const std::string& name) {
    for (const char* directory : font_directories) {
        std::error_code none;
        if (std::filesystem::exists(directory + name, none)) return directory + name;
    }
    throw InputError(name, "", "is not installed, the legend needs it",
                     "install the DejaVu fonts (Debian: fonts-dejavu-core) or leave the legend out with --no-legend");
}

/// Next code point of UTF-8 text, which it shortens; U+FFFD for a byte that is none.
char32_t next_code_point(std::string_view& text) {
    const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80 ? 1 : first >= 0xF0 && first < 0xF8 ? 4 : first >= 0xE0 ? 3 : 2;
    char32_t code = first < 0x80 ? first : first & (0x7FU >> length);
    bool good = first < 0x80 || (first >= 0xC2 && first < 0xF8 && length <= text.size());
    for (std::size_t i = 1; good && i < length; ++i) {
        good = (byte(i) & 0xC0U) == 0x80;
        code = code << 6 | (byte(i) & 0x3FU);
    }
    text.remove_prefix(good ? length : 1);
    return good ? code : 0xFFFD;
}

void blend(Image& image, int x, int y, Rgb colour, double alpha) {
    if (x < 0 || y < 0 || x >= image.width || y >= image.height || alpha <= 0) return;
    std::uint8_t* p = image.pixel(x, y);
    const double below = image.channels == 4 ? p[3] / 255.0 : 1.0;
    const double total = alpha + below * (1 - alpha);
    const auto mix = [&](std::uint8_t old, std::uint8_t fresh) {
        return static_cast<std::uint8_t>(std::lround((fresh * alpha + old * below * (1 - alpha)) / total));
    };
    p[0] = mix(p[0], colour.r), p[1] = mix(p[1], colour.g), p[2] = mix(p[2], colour.b);
    if (image.channels == 4) p[3] = static_cast<std::uint8_t>(std::lround(255 * total));
}

}  // namespace

struct TextPainter::Impl {
    FT_Library library = nullptr;
    FT_Face regular = nullptr, bold = nullptr;

    FT_Face face(const TextStyle& style) {
        const FT_Face chosen = style.bold ? bold : regular;
        const auto size = static_cast<FT_F26Dot6>(std::lround(std::max(6.0, style.size) * 64));
        ENSURE(FT_Set_Char_Size(chosen, 0, size, 72, 72) == 0, "font size ", style.size);
        return chosen;
    }
    /// Calls glyph(face, pen) with every loaded glyph and its pen position [pixels]; returns the advance.
    template <class Use>
    double walk(std::string_view text, const TextStyle& style, FT_Int32 flags, const Use& use) {
        const FT_Face font = face(style);
        double pen = 0;
        FT_UInt last = 0;
        while (!text.empty()) {
            const FT_UInt index = FT_Get_Char_Index(font, next_code_point(text));
            FT_Vector kerning{};
            if (last && index) FT_Get_Kerning(font, last, index, FT_KERNING_UNFITTED, &kerning);
            pen += static_cast<double>(kerning.x) / 64;
            last = index;
            if (FT_Load_Glyph(font, index, flags) != 0) continue;
            use(font, pen);
            pen += static_cast<double>(font->glyph->linearHoriAdvance) / 65536;
        }
        return pen;
    }
};

TextPainter::TextPainter() : impl_(std::make_unique<Impl>()) {
    ENSURE(FT_Init_FreeType(&impl_->library) == 0, "FreeType does not start");
    const auto load = [this](const char* name, FT_Face& face) {
        const std::string file = find_font(name);
        if (FT_New_Face(impl_->library, file.c_str(), 0, &face) != 0)
            throw InputError(file, "", "is not a font that FreeType reads", "reinstall the DejaVu fonts");
    };
    try {
        load("DejaVuSans.ttf", impl_->regular);
        load("DejaVuSans-Bold.ttf", impl_->bold);
    } catch (...) {
        FT_Done_FreeType(impl_->library);  // frees the faces too
        throw;
    }
}

TextPainter::~TextPainter() { FT_Done_FreeType(impl_->library); }

double TextPainter::width(std::string_view text, const TextStyle& style) {
    return impl_->walk(text, style, FT_LOAD_TARGET_LIGHT, [](FT_Face, double) {});
}

void TextPainter::draw(Image& image, double x, double y, std::string_view text, const TextStyle& style) {
    const int baseline = static_cast<int>(std::lround(y));
    impl_->walk(text, style, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT, [&](FT_Face font, double pen) {
        const FT_GlyphSlot glyph = font->glyph;
        const int left = static_cast<int>(std::lround(x + pen)) + glyph->bitmap_left;
        const int top = baseline - glyph->bitmap_top;
        for (int row = 0; row < static_cast<int>(glyph->bitmap.rows); ++row) {
            const unsigned char* line = glyph->bitmap.buffer + row * glyph->bitmap.pitch;
            for (int column = 0; column < static_cast<int>(glyph->bitmap.width); ++column)
                blend(image, left + column, top + row, style.colour, line[column] / 255.0);
        }
    });
}

void fill_rectangle(Image& image, double x, double y, double width, double height, double radius, Rgb colour) {
    const double half_width = width / 2, half_height = height / 2;
    const double r = std::min({radius, half_width, half_height});
    for (int row = static_cast<int>(std::floor(y)); row < std::ceil(y + height); ++row) {
        for (int column = static_cast<int>(std::floor(x)); column < std::ceil(x + width); ++column) {
            // Signed distance of the pixel's centre to the rounded rectangle.
            const double dx = std::abs(column + 0.5 - x - half_width) - (half_width - r);
            const double dy = std::abs(row + 0.5 - y - half_height) - (half_height - r);
            const double distance =
                std::hypot(std::max(dx, 0.0), std::max(dy, 0.0)) + std::min(std::max(dx, dy), 0.0) - r;
            blend(image, column, row, colour, std::clamp(0.5 - distance, 0.0, 1.0));
        }
    }
}

}  // namespace tetfront
