#include "server/cli/chart.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <pugixml.hpp>

namespace tetfront {
namespace {

pugi::xml_document parse(const Chart& chart) {
    pugi::xml_document svg;
    EXPECT_TRUE(svg.load_string(to_svg(chart).c_str()));
    return svg;
}

std::vector<std::string> texts(const pugi::xml_document& svg) {
    std::vector<std::string> found;
    for (const auto& node : svg.select_nodes("//text")) found.emplace_back(node.node().text().get());
    return found;
}

std::vector<std::array<double, 2>> polyline(const pugi::xml_document& svg) {
    std::vector<std::array<double, 2>> points;
    std::istringstream list(svg.select_node("//polyline").node().attribute("points").value());
    for (std::array<double, 2> p{}; list >> p[0];) {
        list.ignore(1);
        list >> p[1];
        points.push_back(p);
    }
    return points;
}

Chart sample() {
    return {.title = "Speed & <error>",
            .subtitle = "",
            .x = "ms a step",
            .y = "error, %",
            .series = {{.name = "lines", .line = true, .points = {{1, 0.1, "0.02"}, {10, 0.01, "0.01"}, {100, 0.001, "\"x\""}}},
                       {.name = "marker", .line = false, .points = {{3, 0.5, ""}}}},
            .rules = {{.name = "reference", .x = 50}}};
}

TEST(Chart, ShowsTitleAxesLegendAndLabelsAsTheyWereWritten) {
    const auto svg = parse(sample());
    const auto found = texts(svg);
    for (const char* text : {"Speed & <error>", "ms a step", "error, %", "lines", "marker", "reference", "0.02", "\"x\"", "1", "100", "0.001"})
        EXPECT_NE(std::ranges::find(found, text), found.end()) << text;
}

TEST(Chart, AxesAreLogarithmicAndYGrowsUpwards) {
    const auto svg = parse(sample());
    const auto points = polyline(svg);
    ASSERT_EQ(points.size(), 3U);
    EXPECT_NEAR(points[1][0] - points[0][0], points[2][0] - points[1][0], 0.01) << "a factor of 10 each";
    EXPECT_GT(points[1][0], points[0][0]);
    EXPECT_NEAR(points[1][1] - points[0][1], points[2][1] - points[1][1], 0.01);
    EXPECT_GT(points[1][1], points[0][1]) << "smaller errors are lower, and y points down";
}

TEST(Chart, LinearAxesHaveZeroAndNegativeValuesAndEqualSteps) {
    Chart chart = sample();
    chart.logarithmic_x = chart.logarithmic_y = false;
    chart.rules.clear();
    chart.series = {{.name = "s", .line = true, .points = {{-1, -10, ""}, {0, 0, ""}, {1, 10, ""}}, .markers = false, .dashed = true}};
    const auto svg = parse(chart);
    const auto points = polyline(svg);
    ASSERT_EQ(points.size(), 3U);
    for (std::size_t c : {0U, 1U}) EXPECT_NEAR(points[1][c] - points[0][c], points[2][c] - points[1][c], 0.01);
    EXPECT_GT(points[1][1], points[2][1]) << "y grows upwards";
    EXPECT_TRUE(svg.select_nodes("//circle").empty()) << "no markers";
    EXPECT_STRNE(svg.select_node("//polyline").node().attribute("stroke-dasharray").value(), "");
    const auto found = texts(svg);
    for (const char* tick : {"-1", "0", "1", "-10", "10"}) EXPECT_NE(std::ranges::find(found, tick), found.end()) << tick;
}

TEST(Chart, LeavesOutWhatHasNoPlace) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Chart chart{.title = "", .subtitle = "", .x = "", .y = "", .series = {{.name = "s", .line = true, .points = {{0, 1, ""}, {1, -1, ""}, {nan, 1, ""}}}}, .rules = {{"r", 0}}};
    const std::string text = to_svg(chart);
    EXPECT_EQ(text.find("nan"), std::string::npos);
    EXPECT_EQ(text.find("inf"), std::string::npos);
    EXPECT_EQ(parse(chart).select_nodes("//circle").size(), 1U) << "the legend's";
    EXPECT_TRUE(parse({}).child("svg")) << "nothing at all is still a picture";
}

TEST(Chart, NeighboursShareALabel) {
    Chart chart = sample();
    chart.series[0].points = {{1, 0.1, "0.2"}, {1.0001, 0.1, "0.1"}, {1.0002, 0.1, "0.05"}, {90, 0.001, "0.01"}};
    const auto found = texts(parse(chart));
    EXPECT_NE(std::ranges::find(found, "0.2 to 0.05"), found.end());
    EXPECT_NE(std::ranges::find(found, "0.01"), found.end());
}

}  // namespace
}  // namespace tetfront
