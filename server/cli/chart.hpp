#pragma once
// A chart with two logarithmic axes as SVG: lines with markers, lone markers, vertical rules, axes, grid and legend.
//
//     Chart chart{.title = "Speed against error", .x = "milliseconds a step", .y = "error"};
//     chart.series.push_back({.name = "quadratic", .line = true, .points = {{1.5, 0.1, "0.02"}, {3, 0.04, "0.01"}}});
//     write_atomically("study.svg", to_svg(chart));

#include <string>
#include <vector>

namespace tetfront {

struct Chart {
    struct Point {
        double x = 0, y = 0;  // > 0 and finite; other points are left out
        std::string label;    // beside the marker; may be empty
    };
    struct Series {
        std::string name;
        bool line = false;  // joins the points in their order
        std::vector<Point> points;
    };
    /// A vertical line over the whole height.
    struct Rule {
        std::string name;
        double x = 0;  // > 0
    };
    std::string title, subtitle;  // any text; it is escaped
    std::string x, y;             // what the axes show, with units
    std::vector<Series> series;   // at most 8 colours, then they repeat
    std::vector<Rule> rules;
};

/// A whole SVG file, 1090 x 560, black on white.
std::string to_svg(const Chart& chart);

}  // namespace tetfront
