#include "server/render/palette.hpp"
#include "tests/support/project.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {

void PrintTo(const Rgb& c, std::ostream* out) { *out << int{c.r} << ' ' << int{c.g} << ' ' << int{c.b}; }

namespace {

nlohmann::json golden() {
    std::ifstream in(source_folder() / "tests/golden/palette.json");
    return nlohmann::json::parse(in);
}

std::string hex(Rgb c) {
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", c.r, c.g, c.b);
    return text;
}

using Linear = std::array<double, 3>;

Linear linear(Rgb c) {
    const auto decode = [](double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); };
    return {decode(c.r / 255.0), decode(c.g / 255.0), decode(c.b / 255.0)};
}

Linear multiply(const std::array<Linear, 3>& m, const Linear& v) {
    Linear result{};
    for (std::size_t i = 0; i < 3; ++i) result[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return result;
}

/// Oklab (Ottosson 2020): lightness and two colour axes in which distances are about as large as they look.
Linear oklab(const Linear& rgb) {
    Linear cones = multiply({{{0.4122214708, 0.5363325363, 0.0514459929},
                              {0.2119034982, 0.6806995451, 0.1073969566},
                              {0.0883024619, 0.2817188376, 0.6299787005}}},
                            rgb);
    for (double& x : cones) x = std::cbrt(std::max(x, 0.0));
    return multiply({{{0.2104542553, 0.7936177850, -0.0040720468},
                      {1.9779984951, -2.4285922050, 0.4505937099},
                      {0.0259040371, 0.7827717662, -0.8086757660}}},
                    cones);
}

double distance(const Linear& a, const Linear& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// Full colour blindness of a kind, on linear RGB (Machado et al. 2009).
const std::array<std::pair<const char*, std::array<Linear, 3>>, 4> eyes = {{
    {"all colours", {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
    {"no red", {{{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}}},
    {"no green", {{{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}}},
    {"no blue", {{{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}}},
}};

TEST(Palette, HasTheNumbersThatTheBrowserHas) {
    const auto file = golden();
    ASSERT_EQ(file["levels"].size(), level_colours.size());
    for (std::size_t i = 0; i < level_colours.size(); ++i) EXPECT_EQ(hex(level_colours[i]), file["levels"][i]);
    ASSERT_EQ(file["stiffness"].size(), stiffness_colours.size());
    for (std::size_t i = 0; i < stiffness_colours.size(); ++i)
        EXPECT_EQ(hex(stiffness_colours[i]), file["stiffness"][i]);
    ASSERT_EQ(file["field"].size(), field_colours.size());
    for (std::size_t i = 0; i < field_colours.size(); ++i) EXPECT_EQ(hex(field_colours[i]), file["field"][i]);
    ASSERT_EQ(file["error"].size(), error_colours.size());
    for (std::size_t i = 0; i < error_colours.size(); ++i) EXPECT_EQ(hex(error_colours[i]), file["error"][i]);
    EXPECT_EQ(hex(pull_colour), file["pull"]);
    EXPECT_EQ(hex(force_colour), file["force"]);
    ASSERT_FALSE(file["samples"].empty());
    for (const auto& sample : file["samples"]) {
        const auto range = sample["range"].get<std::array<float, 2>>();
        const double position = stiffness_position(sample["young"].get<float>(), range);
        EXPECT_NEAR(position, sample["position"].get<double>(), 1e-6) << sample;
        const auto c = sample["colour"].get<std::array<int, 3>>();
        const Rgb seen = map_colour(position);
        EXPECT_NEAR(seen.r, c[0], 1) << sample;
        EXPECT_NEAR(seen.g, c[1], 1) << sample;
        EXPECT_NEAR(seen.b, c[2], 1) << sample;
    }
}

TEST(Palette, EndsAreClamped) {
    EXPECT_EQ(level_colour(-1), level_colours.front());
    EXPECT_EQ(level_colour(99), level_colours.back());
    EXPECT_EQ(map_colour(-1), stiffness_colours.front());
    EXPECT_EQ(map_colour(2), stiffness_colours.back());
    EXPECT_EQ(map_colour(0.25), stiffness_colours[2]);
}

TEST(Palette, LevelsAreOrderedByLightnessAndDistinctToEveryEye) {
    for (const auto& [who, vision] : eyes) {
        for (std::size_t i = 0; i + 1 < level_colours.size(); ++i) {
            const Linear a = oklab(multiply(vision, linear(level_colours[i])));
            const Linear b = oklab(multiply(vision, linear(level_colours[i + 1])));
            EXPECT_GT(b[0], a[0]) << "lightness of levels " << i << " and " << i + 1 << ", " << who;
            EXPECT_GT(distance(a, b), 0.045) << "levels " << i << " and " << i + 1 << ", " << who;
        }
    }
}

TEST(Palette, FieldsGrowLighterInEvenSteps) {
    for (const auto& [who, vision] : eyes) {
        for (const std::span<const Rgb> map : {std::span<const Rgb>(field_colours), std::span<const Rgb>(error_colours)}) {
            std::vector<double> steps;
            for (std::size_t i = 0; i + 1 < map.size(); ++i) {
                const Linear a = oklab(multiply(vision, linear(map[i]))), b = oklab(multiply(vision, linear(map[i + 1])));
                EXPECT_GT(b[0], a[0]) << "stops " << i << " and " << i + 1 << ", " << who;
                steps.push_back(distance(a, b));
            }
            EXPECT_LT(*std::ranges::max_element(steps), 3.5 * *std::ranges::min_element(steps)) << who;
        }
    }
}

TEST(Palette, StiffnessGrowsDarkerInEvenSteps) {
    for (const auto& [who, vision] : eyes) {
        for (std::size_t i = 0; i + 1 < stiffness_colours.size(); ++i) {
            const Linear a = oklab(multiply(vision, linear(stiffness_colours[i])));
            const Linear b = oklab(multiply(vision, linear(stiffness_colours[i + 1])));
            EXPECT_LT(b[0], a[0]) << "stops " << i << " and " << i + 1 << ", " << who;
            EXPECT_GT(distance(a, b), 0.03) << "stops " << i << " and " << i + 1 << ", " << who;
            EXPECT_LT(distance(a, b), 0.13) << "stops " << i << " and " << i + 1 << ", " << who;
        }
    }
}

}  // namespace
}  // namespace tetfront
