#pragma once
// A chart as SVG: lines with or without markers, lone markers, vertical rules, axes, grid and legend. Axes are logarithmic
// unless they say otherwise.
//
//     Chart chart{.title = "Speed against error", .x = "milliseconds a step", .y = "error"};
//     chart.series.push_back({.name = "quadratic", .line = true, .points = {{1.5, 0.1, "0.02"}, {3, 0.04, "0.01"}}});
//     write_atomically("study.svg", to_svg(chart));

#include <string>
#include <vector>

namespace tetfront {

struct Chart {
    struct Point {
        double x = 0, y = 0;  // finite, > 0 along a logarithmic axis; other points are left out
        std::string label;    // beside the marker; may be empty
    };
    struct Series {
        std::string name;
        bool line = false;  // joins the points in their order
        std::vector<Point> points;
        bool markers = true;  // on the line's points; lone points always have one
        bool dashed = false;
    };
    /// A vertical line over the whole height.
    struct Rule {
        std::string name;
        double x = 0;  // > 0 along a logarithmic axis
    };
    std::string title, subtitle;  // any text; it is escaped
    std::string x, y;             // what the axes show, with units
    std::vector<Series> series;   // at most 8 colours, then they repeat
    std::vector<Rule> rules;
    bool logarithmic_x = true, logarithmic_y = true;
};

/// A whole SVG file, 1090 x 560, black on white.
std::string to_svg(const Chart& chart);

}  // namespace tetfront
