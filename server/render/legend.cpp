#include "server/render/legend.hpp"

#include "server/render/colour_scale.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

namespace tetfront {

namespace {

struct Inks {
    Rgb strong, normal, weak, warning;
};
Inks inks(Background background) {
    if (background == Background::dark)
        return {{0xf2, 0xf4, 0xf7}, {0xcf, 0xd4, 0xdb}, {0x8a, 0x92, 0x9e}, {0xff, 0x9a, 0x76}};
    return {{0x1c, 0x22, 0x2b}, {0x3f, 0x48, 0x55}, {0x8b, 0x93, 0x9f}, {0xb0, 0x2a, 0x12}};
}

std::string number(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/// One drawing of the legend: where, with what.
class Page {
 public:
    Page(Image& image, TextPainter& painter, const View& view)
        : image_(image), painter_(painter), inks_(inks(view.background)), unit_(std::max(0.62, image.height / 720.0)) {}

    void header(const Frame& frame, const std::string& title);
    void key(const Frame& frame, const View& view);

 private:
    void levels(const Frame& frame, bool as_lines);
    void scale(const ColourScale& colours);
    [[nodiscard]] double px(double at_720) const { return at_720 * unit_; }
    /// Reserves a block above what is there already; false when the picture has no room for it.
    bool reserve(double height, double width) {
        if (bottom_ - height < top_ || width + 2 * px(margin) > image_.width) return false;
        bottom_ -= height;
        return true;
    }
    void text(double x, double y, const std::string& words, double size, Rgb colour, bool bold = false) {
        painter_.draw(image_, x, y, words, {px(size), colour, bold});
    }
    double width(const std::string& words, double size, bool bold = false) {
        return painter_.width(words, {px(size), {}, bold});
    }

    static constexpr double margin = 26, title_size = 20, text_size = 13.5;
    Image& image_;
    TextPainter& painter_;
    Inks inks_;
    double unit_;  // pixels per pixel of a picture 720 high
    double top_ = px(margin), bottom_ = image_.height - px(margin);
};

void Page::header(const Frame& frame, const std::string& title) {
    const FrameStatus& status = frame.status;
    const auto& counts = frame.topology->tets_by_level;
    const std::uint64_t tets = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    std::string numbers = "t = " + number("%.2f", status.time) + " s   ·   " + with_thousands(tets) + " tets";
    if (status.estimate > 1e-6)  // at rest there is nothing but rounding
        numbers += "   ·   error estimate " + number("%.2g", 100 * status.estimate) + " %";
    double pulled = 0;
    for (const FramePull& pull : frame.pulls) pulled += static_cast<double>(pull.force);
    if (!frame.pulls.empty()) numbers += "   ·   pull " + newtons(pulled);
    double forces = 0;
    for (const FrameForce& f : frame.forces) forces += Vec3(f.value[0], f.value[1], f.value[2]).norm();
    if (!frame.forces.empty()) numbers += "   ·   forces " + newtons(forces);
    const double available = image_.width - 2 * px(margin);
    if (!title.empty() && width(title, title_size, true) <= available) {
        text(px(margin), top_ + px(15), title, title_size, inks_.strong, true);
        top_ += px(27);
    }
    if (width(numbers, text_size) <= available) {
        text(px(margin), top_ + px(11), numbers, text_size, inks_.normal);
        top_ += px(22);
    }
    if (!status.warning.empty() && width(status.warning, text_size) <= available) {
        text(px(margin), top_ + px(11), status.warning, text_size, inks_.warning);
        top_ += px(22);
    }
}

void Page::levels(const Frame& frame, bool as_lines) {
    const auto& counts = frame.topology->tets_by_level;
    std::vector<std::string> tets;
    double widest = 0;
    for (const std::uint32_t count : counts) {
        tets.push_back(with_thousands(count));
        widest = std::max(widest, width(tets.back(), text_size));
    }
    const double row = px(21), label = px(margin + 28), heading = px(24);
    const double numbers_end = label + width("level 0", text_size) + px(18) + widest;
    const double rows = row * static_cast<double>(counts.size());
    if (!reserve(heading + rows, numbers_end + width(" tets", text_size) - px(margin))) return;
    text(px(margin), bottom_ + px(11), as_lines ? "Edges of the front" : "Level of refinement", text_size, inks_.strong,
         true);
    for (std::size_t level = 0; level < counts.size(); ++level) {
        const double y = bottom_ + heading + row * static_cast<double>(level);
        const Rgb colour = level_colour(static_cast<int>(level)), ink = counts[level] ? inks_.normal : inks_.weak;
        const double height = as_lines ? px(3.5) : px(14);
        fill_rectangle(image_, px(margin), y + px(8) - height / 2, px(18), height, px(3), colour);
        text(label, y + px(13), "level " + std::to_string(level), text_size, ink);
        text(numbers_end - width(tets[level], text_size), y + px(13), tets[level], text_size, ink);
        text(numbers_end, y + px(13), " tets", text_size, ink);
    }
}

void Page::scale(const ColourScale& colours) {
    const double bar = px(240), bar_height = px(12), x = px(margin);
    if (!reserve(px(62), bar)) return;
    text(x, bottom_ + px(11), colours.title, text_size, inks_.strong, true);
    const double title_width = width(colours.title, text_size, true);
    const std::string how = colours.single() ? "  the same everywhere" : colours.logarithmic ? "  logarithmic" : "";
    text(x + title_width, bottom_ + px(11), how, text_size, inks_.weak);
    const double y = bottom_ + px(24);
    if (colours.single()) {
        fill_rectangle(image_, x, y, px(18), px(14), px(3), colours.colour(colours.range[0]));
        text(x + px(28), y + px(12), colours.label(colours.range[0]), text_size, inks_.normal);
        return;
    }
    const int columns = static_cast<int>(bar);
    for (int i = 0; i < columns; ++i)
        fill_rectangle(image_, std::floor(x) + i, y, 1, bar_height, 0, map_colour((i + 0.5) / columns, colours.stops));
    for (int i = 0; i < 3; ++i) {
        fill_rectangle(image_, std::floor(x) + std::min(i * bar / 2, bar - 1), y + bar_height, 1, px(4), 0, inks_.weak);
        const std::string label = (i == 2 && colours.open ? "≥ " : "") + colours.label(colours.value_at(i / 2.0));
        text(x + i * bar / 2 - i * width(label, text_size) / 2, y + bar_height + px(19), label, text_size, inks_.normal);
    }
}

void Page::key(const Frame& frame, const View& view) {
    const bool by_scale = view.surface && view.colouring != Colouring::level;
    if (by_scale) {
        scale(colour_scale(frame, view));
        bottom_ -= px(14);
    }
    if (!by_scale || view.wireframe) levels(frame, by_scale || !view.surface);
}

}  // namespace

void Legend::draw(Image& image, const Frame& frame, const View& view, const std::string& title) {
    if (!painter_) painter_ = std::make_unique<TextPainter>();
    Page page(image, *painter_, view);
    page.header(frame, title);
    page.key(frame, view);
}

std::string with_thousands(std::uint64_t number) {
    std::string digits = std::to_string(number);
    for (std::size_t i = digits.size(); i > 3;) digits.insert(i -= 3, 1, ',');
    return digits;
}

}  // namespace tetfront
