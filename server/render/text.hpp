#pragma once
// Words and plain shapes on an image, antialiased, straight over the pixels. Rows and baselines count from the top.
//
//     TextPainter painter;
//     float width = painter.width("12,345 tets", {14});
//     painter.draw(image, 24, 40, "12,345 tets", {14, ink});

#include "server/render/image.hpp"
#include "server/render/palette.hpp"

#include <memory>
#include <string_view>

namespace tetfront {

struct TextStyle {
    double size = 14;  // [pixels] em height, at least 6
    Rgb colour{};
    bool bold = false;
};

class TextPainter {
 public:
    /// Loads DejaVu Sans; throws InputError when it is not installed.
    TextPainter();
    ~TextPainter();
    TextPainter(const TextPainter&) = delete;
    TextPainter& operator=(const TextPainter&) = delete;

    /// Advance of one line of UTF-8 [pixels].
    double width(std::string_view text, const TextStyle& style);
    /// x: left end, y: baseline. Characters without a glyph show the font's box. Outside of the image: cut off.
    void draw(Image& image, double x, double y, std::string_view text, const TextStyle& style);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// The rectangle [x, x + width] x [y, y + height] with rounded corners.
void fill_rectangle(Image& image, double x, double y, double width, double height, double radius, Rgb colour);

}  // namespace tetfront
