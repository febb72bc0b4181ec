#include "server/render/legend.hpp"

#include "server/render/colour_scale.hpp"
#include "server/render/text.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/pictures.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

struct Extent {
    int left = 1 << 20, top = 1 << 20, right = -1, bottom = -1, count = 0;
};
/// Where the image is not black.
Extent drawn(const Image& image) {
    Extent e;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* p = image.pixel(x, y);
            if (p[0] + p[1] + p[2] == 0) continue;
            e.left = std::min(e.left, x), e.right = std::max(e.right, x);
            e.top = std::min(e.top, y), e.bottom = std::max(e.bottom, y);
            ++e.count;
        }
    }
    return e;
}

constexpr Rgb white{255, 255, 255};

TEST(Text, StandsOnItsBaselineAndIsAsWideAsAnnounced) {
    TextPainter painter;
    Image image(300, 60, 3);
    const TextStyle style{20, white, false};
    painter.draw(image, 10, 40, "HEIGHT", style);
    const Extent e = drawn(image);
    EXPECT_EQ(e.bottom, 39) << "capitals end on the row above the baseline";
    EXPECT_NEAR(e.bottom - e.top + 1, 0.73 * 20, 1.5) << "height of DejaVu's capitals";
    EXPECT_NEAR(e.right - e.left + 1, painter.width("HEIGHT", style), 5);
    EXPECT_GT(painter.width("HEIGHT", {20, white, true}), painter.width("HEIGHT", style)) << "bold is wider";
    EXPECT_NEAR(painter.width("HEIGHT", {40, white, false}), 2 * painter.width("HEIGHT", style), 1e-3);
}

TEST(Text, AnyBytesAndPlacesAreHarmless) {
    TextPainter painter;
    Image image(40, 20, 4);
    for (const char* text : {"", "\xff\xfe\x80", "\xe2\x82", "\xf0\x9f\x90\xb0", "Young’s modulus ±5 % 弾性"}) {
        for (const double x : {-500.0, -3.0, 38.0, 5000.0}) painter.draw(image, x, 12, text, {14, white, false});
    }
    // Text on a transparent image is as opaque as its ink.
    Image clear(40, 20, 4);
    painter.draw(clear, 2, 16, "M", {16, {200, 100, 50}, false});
    bool opaque = false;
    for (int i = 0; i < 40 * 20; ++i) {
        const std::uint8_t* p = clear.pixel(i % 40, i / 40);
        if (p[3] == 255) opaque = true;
        if (p[3] > 0) EXPECT_NEAR(p[0], 200, 2);
    }
    EXPECT_TRUE(opaque);
}

TEST(Text, RectanglesHaveTheirArea) {
    Image image(100, 100, 3);
    fill_rectangle(image, 10, 20, 30, 40, 0, white);
    const Extent e = drawn(image);
    EXPECT_EQ(e.count, 30 * 40);
    EXPECT_EQ(e.left, 10);
    EXPECT_EQ(e.bottom, 59);
    Image rounded(100, 100, 3);
    fill_rectangle(rounded, 10, 20, 30, 40, 8, white);
    double area = 0;
    for (const std::uint8_t x : rounded.pixels) area += x / 255.0 / 3;
    EXPECT_NEAR(area, 30 * 40 - (4 - 3.14159) * 64, 3);
}

TEST(Legend, WritesNumbersForPeople) {
    EXPECT_EQ(with_thousands(0), "0");
    EXPECT_EQ(with_thousands(999), "999");
    EXPECT_EQ(with_thousands(1000), "1,000");
    EXPECT_EQ(with_thousands(12345678), "12,345,678");
    EXPECT_EQ(pascals(0), "0 Pa");
    EXPECT_EQ(pascals(250), "250 Pa");
    EXPECT_EQ(pascals(999.6), "1 kPa");
    EXPECT_EQ(pascals(2.5e5), "250 kPa");
    EXPECT_EQ(pascals(1.2345e6), "1.23 MPa");
    EXPECT_EQ(pascals(7e15), "7e+03 TPa");
    EXPECT_EQ(metres(0), "0 m");
    EXPECT_EQ(metres(0.0123), "12.3 mm");
    EXPECT_EQ(metres(1.5), "1.5 m");
    EXPECT_EQ(metres(2e-7), "200 nm");
    EXPECT_EQ(percent(0.0123), "1.23 %");
}

TEST(ColourScale, EndsAreReadableNumbers) {
    for (const auto& [x, expected] : {std::pair{0.0, 0.0}, {-1.0, 0.0}, {1.0, 1.0}, {1.01, 1.5}, {2.0, 2.0}, {2.1, 3.0},
                                      {5.0, 5.0}, {7.0, 8.0}, {9.99, 10.0}, {0.034, 0.04}, {1.7e5, 2e5}, {1e-12, 1e-12}})
        EXPECT_NEAR(readable_ceiling(x), expected, 1e-9 * expected) << x;
    EXPECT_EQ(readable_ceiling(std::numeric_limits<double>::infinity()), 0);
    const ColourScale scale{field_colours, {10, 1000}, true, false, "", metres};
    EXPECT_DOUBLE_EQ(scale.value_at(0.5), 100);
    EXPECT_DOUBLE_EQ(scale.position(100), 0.5);
    EXPECT_EQ(scale.position(std::numeric_limits<double>::quiet_NaN()), 0);
    EXPECT_EQ(scale.position(-5), 0);
}

TEST(Legend, ShowsTheColoursThatThePictureUses) {
    const auto frame = blob_frame(4);
    const auto contains = [](const Image& image, Rgb c) {
        for (int i = 0; i < image.width * image.height; ++i) {
            const std::uint8_t* p = image.pixel(i % image.width, i / image.width);
            if (Rgb{p[0], p[1], p[2]} == c) return true;
        }
        return false;
    };
    Legend legend;
    View view;
    Image by_level(1280, 720, 3);
    legend.draw(by_level, *frame, view, "Blob");
    for (int level = 0; level <= 2; ++level) EXPECT_TRUE(contains(by_level, level_colour(level))) << level;
    EXPECT_FALSE(contains(by_level, level_colour(3)));
    view.colouring = Colouring::stiffness;
    Image by_stiffness(1280, 720, 3);
    legend.draw(by_stiffness, *frame, view, "Blob");
    EXPECT_FALSE(contains(by_stiffness, level_colour(0)));
    EXPECT_TRUE(contains(by_stiffness, map_colour(0.5 / 240)));
    EXPECT_TRUE(contains(by_stiffness, map_colour(239.5 / 240)));
    view.wireframe = true;
    legend.draw(by_stiffness, *frame, view, "Blob");
    EXPECT_TRUE(contains(by_stiffness, level_colour(0))) << "the edges' colours need their legend as well";
}

TEST(Legend, LeavesOutWhatDoesNotFit) {
    const auto frame = blob_frame(4);
    for (const auto& [width, height] : {std::pair{16, 16}, {60, 400}, {400, 40}}) {
        Image image(width, height, 3);
        Legend().draw(image, *frame, View{},
                      "A title that is longer than the picture is wide, by far and in every size");
        EXPECT_LT(drawn(image).count, width * height / 2);
    }
}

}  // namespace
}  // namespace tetfront
