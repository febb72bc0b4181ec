#include "server/cli/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

namespace tetfront {

namespace {

constexpr double width = 1090, height = 560;
constexpr double left = 84, right = 310, top = 66, bottom = 62;
// Okabe & Ito's colours, which colour-blind eyes can tell apart, the yellow left out.
constexpr std::array<const char*, 8> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                "#56b4e9", "#e69f00", "#000000", "#777777"};

std::string escape(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        if (c == '&') safe += "&amp;";
        else if (c == '<') safe += "&lt;";
        else if (c == '>') safe += "&gt;";
        else if (c == '"') safe += "&quot;";
        else if (static_cast<unsigned char>(c) < 0x20) safe += ' ';  // control characters are not allowed in XML
        else safe += c;
    }
    return safe;
}

std::string number(double value, const char* format = "%.6g") {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/// One axis: from values to pixels, and where its ticks are.
class Axis {
 public:
    Axis(double begin, double end, bool logarithmic) : begin_(begin), end_(end), logarithmic_(logarithmic) {}
    [[nodiscard]] bool has(double value) const { return std::isfinite(value) && (value > 0 || !logarithmic_); }
    void cover(double value) {
        low_ = std::min(low_, value);
        high_ = std::max(high_, value);
    }
    /// Some air on both sides; on a logarithmic axis at least half a decade.
    void round() {
        if (!(low_ <= high_)) low_ = high_ = 1;
        if (!logarithmic_) {
            const double air = high_ > low_ ? 0.04 * (high_ - low_) : std::max(std::abs(low_), 1.0);
            low_ = low_ >= 0 && low_ <= 4 * air ? 0 : low_ - air;  // from 0 where that is near
            high_ += air;
            return;
        }
        const double air = std::max(0.06 * std::log10(high_ / low_), 0.15);
        low_ *= std::pow(10, -air);
        high_ *= std::pow(10, air);
    }
    [[nodiscard]] double at(double value) const {
        if (!logarithmic_) return begin_ + (end_ - begin_) * (value - low_) / (high_ - low_);
        return begin_ + (end_ - begin_) * std::log(value / low_) / std::log(high_ / low_);
    }
    struct Tick {
        double value;
        bool labelled;
    };
    /// 1, 2, 5 of each decade have numbers while there are few decades, later the powers of ten only. A linear axis has
    /// five to ten round numbers.
    [[nodiscard]] std::vector<Tick> ticks() const {
        std::vector<Tick> result;
        if (!logarithmic_) {
            const double power = std::pow(10, std::floor(std::log10((high_ - low_) / 5))), most = (high_ - low_) / 5 / power;
            const double step = power * (most >= 5 ? 5 : most >= 2 ? 2 : 1);
            for (double n = std::ceil(low_ / step); n * step <= high_; ++n) result.push_back({n * step, true});
            return result;
        }
        const double decades = std::log10(high_ / low_);
        for (int e = static_cast<int>(std::floor(std::log10(low_))); e <= static_cast<int>(std::ceil(std::log10(high_))); ++e) {
            for (int digit = 1; digit <= 9; ++digit) {
                const double value = digit * std::pow(10, e);
                if (value < low_ || value > high_) continue;
                const bool few = digit == 1 || (decades < 3.2 && (digit == 2 || digit == 5));
                if (decades > 5 && digit != 1) continue;
                result.push_back({value, few});
            }
        }
        return result;
    }

 private:
    double begin_, end_;  // [pixels]
    bool logarithmic_;
    double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

class Drawing {
 public:
    explicit Drawing(const Chart& chart)
        : chart_(chart), x_(left, width - right, chart.logarithmic_x), y_(height - bottom, top, chart.logarithmic_y) {
        for (const Chart::Series& s : chart.series) {
            for (const Chart::Point& p : s.points) {
                if (!drawable(p)) continue;
                x_.cover(p.x);
                y_.cover(p.y);
            }
        }
        for (const Chart::Rule& r : chart.rules)
            if (x_.has(r.x)) x_.cover(r.x);
        x_.round();
        y_.round();
    }

    std::string svg() {
        out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\"" << width
             << "\" height=\"" << height << "\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n"
             << "<title>" << escape(chart_.title) << "</title>\n"
             << "<rect width=\"" << width << "\" height=\"" << height << "\" fill=\"#fff\"/>\n";
        text(left, 28, chart_.title, "font-size=\"18\" font-weight=\"bold\"");
        text(left, 50, chart_.subtitle, "fill=\"#555\"");
        grid();
        for (std::size_t i = 0; i < chart_.rules.size(); ++i) rule(chart_.rules[i]);
        for (std::size_t i = 0; i < chart_.series.size(); ++i) series(chart_.series[i], i);
        legend();
        out_ << "</svg>\n";
        return out_.str();
    }

 private:
    [[nodiscard]] bool drawable(const Chart::Point& p) const { return x_.has(p.x) && y_.has(p.y); }
    [[nodiscard]] static const char* dashes(const Chart::Series& s) { return s.dashed ? " stroke-dasharray=\"7 4\"" : ""; }

    void text(double x, double y, const std::string& what, const std::string& attributes = "") {
        if (what.empty()) return;
        out_ << "<text x=\"" << number(x) << "\" y=\"" << number(y) << "\" " << attributes << '>' << escape(what) << "</text>\n";
    }
    void line(double x1, double y1, double x2, double y2, const std::string& attributes) {
        out_ << "<line x1=\"" << number(x1) << "\" y1=\"" << number(y1) << "\" x2=\"" << number(x2) << "\" y2=\"" << number(y2) << "\" "
             << attributes << "/>\n";
    }

    void grid() {
        for (const Axis::Tick& tick : x_.ticks()) {
            const double x = x_.at(tick.value);
            line(x, top, x, height - bottom, tick.labelled ? "stroke=\"#d8d8d8\"" : "stroke=\"#f0f0f0\"");
            if (tick.labelled) text(x, height - bottom + 20, number(tick.value), "text-anchor=\"middle\"");
        }
        for (const Axis::Tick& tick : y_.ticks()) {
            const double y = y_.at(tick.value);
            line(left, y, width - right, y, tick.labelled ? "stroke=\"#d8d8d8\"" : "stroke=\"#f0f0f0\"");
            if (tick.labelled) text(left - 8, y + 4.5, number(tick.value), "text-anchor=\"end\"");
        }
        out_ << "<rect x=\"" << left << "\" y=\"" << top << "\" width=\"" << width - left - right << "\" height=\"" << height - top - bottom
             << "\" fill=\"none\" stroke=\"#888\"/>\n";
        text((left + width - right) / 2, height - 16, chart_.x, "text-anchor=\"middle\" font-size=\"14\"");
        out_ << "<text transform=\"translate(22 " << (top + height - bottom) / 2 << ") rotate(-90)\" text-anchor=\"middle\" font-size=\"14\">"
             << escape(chart_.y) << "</text>\n";
    }

    void rule(const Chart::Rule& r) {
        if (!x_.has(r.x)) return;
        const double x = x_.at(r.x);
        line(x, top, x, height - bottom, "stroke=\"#555\" stroke-dasharray=\"6 4\"");
        out_ << "<text transform=\"translate(" << number(x - 6) << ' ' << height - bottom - 10 << ") rotate(-90)\" fill=\"#555\">"
             << escape(r.name) << "</text>\n";
    }

    void marker(double x, double y, std::size_t index, bool line) {
        const char* const colour = colours[index % colours.size()];
        if (line) {
            out_ << "<circle cx=\"" << number(x) << "\" cy=\"" << number(y) << "\" r=\"4.5\" fill=\"" << colour << "\"/>\n";
        } else {
            out_ << "<rect x=\"" << number(x - 6) << "\" y=\"" << number(y - 6) << "\" width=\"12\" height=\"12\" fill=\"#fff\" stroke=\"" << colour
                 << "\" stroke-width=\"3\"/>\n";
        }
    }

    void series(const Chart::Series& s, std::size_t index) {
        const std::string colour = colours[index % colours.size()];
        if (s.line) {
            out_ << "<polyline fill=\"none\" stroke=\"" << colour << "\" stroke-width=\"2\"" << dashes(s) << " points=\"";
            for (const Chart::Point& p : s.points)
                if (drawable(p)) out_ << number(x_.at(p.x)) << ',' << number(y_.at(p.y)) << ' ';
            out_ << "\"/>\n";
        }
        if (s.line && !s.markers) return;
        for (std::size_t i = 0; i < s.points.size(); ++i) {
            if (!drawable(s.points[i])) continue;
            const double x = x_.at(s.points[i].x), y = y_.at(s.points[i].y);
            marker(x, y, index, s.line);
            // Neighbours too close for labels of their own share one.
            std::string label = s.points[i].label, last;
            for (; i + 1 < s.points.size() && drawable(s.points[i + 1]); ++i) {
                const Chart::Point& next = s.points[i + 1];
                if (std::hypot(x_.at(next.x) - x, y_.at(next.y) - y) > 16) break;
                marker(x_.at(next.x), y_.at(next.y), index, s.line);
                last = next.label;
            }
            if (!last.empty()) label += " to " + last;
            const bool inside = x < width - right - 60;
            text(inside ? x + 9 : x - 9, y - 7, label,
                 "font-size=\"11\" fill=\"" + colour + "\"" + (inside ? "" : " text-anchor=\"end\""));
        }
    }

    /// Right of the plot, where it hides nothing.
    void legend() {
        constexpr double x = width - right + 14, row = 22;
        for (std::size_t i = 0; i < chart_.series.size(); ++i) {
            const double y = top + 12 + row * static_cast<double>(i);
            const Chart::Series& s = chart_.series[i];
            if (s.line)
                line(x, y, x + 20, y, std::string("stroke-width=\"2\" stroke=\"") + colours[i % colours.size()] + "\"" + dashes(s));
            if (!s.line || s.markers) marker(x + 10, y, i, s.line);
            text(x + 28, y + 4.5, s.name, "font-size=\"12\"");
        }
    }

    const Chart& chart_;
    Axis x_, y_;
    std::ostringstream out_;
};

}  // namespace

std::string to_svg(const Chart& chart) { return Drawing(chart).svg(); }

}  // namespace tetfront
