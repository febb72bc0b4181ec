// Samples over a backdrop.

#include "server/render/compose.hpp"

#include "server/render/geometry.hpp"
#include "tests/support/blob_frame.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

TEST(Compose, AveragesSamplesOverTheBackdropAndTurnsRowsOver) {
    // A tile of 2x2 pixels at (1, 0) of a picture 3 wide and 2 high; samples over its lower right pixel.
    const std::vector<std::uint8_t> behind = {10, 20, 30, 255, 40, 50, 60, 255, 70, 80, 90, 255, 100, 110, 120, 255};
    const std::vector<std::uint8_t> rgba = {200, 0, 0, 255, 0, 200, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0};
    Image image(3, 2, 3);
    compose({1, 0, 2, 2}, behind, {{2, 0, 1, 1}, 2, rgba}, image);
    const auto pixel = [&](int x, int y) { return std::vector<int>(image.pixel(x, y), image.pixel(x, y) + 3); };
    EXPECT_EQ(pixel(0, 0), (std::vector<int>{0, 0, 0})) << "not of the tile";
    EXPECT_EQ(pixel(1, 1), (std::vector<int>{10, 20, 30})) << "the first row is the lowest";
    EXPECT_EQ(pixel(1, 0), (std::vector<int>{70, 80, 90}));
    EXPECT_EQ(pixel(2, 0), (std::vector<int>{100, 110, 120}));
    EXPECT_EQ(pixel(2, 1), (std::vector<int>{70, 75, 30})) << "half covered: 200 / 4 + 40 / 2, 200 / 4 + 50 / 2, 60 / 2";
}

TEST(Compose, MakesAlphaStraight) {
    const std::vector<std::uint8_t> behind = {0, 0, 0, 0, 50, 25, 0, 100};
    std::vector<std::uint8_t> rgba(2 * 9 * 4, 0);
    for (std::size_t i = 0; i < 3; ++i) rgba[4 * i] = 90, rgba[4 * i + 3] = 255;  // a third of the first pixel's lowest row
    Image image(2, 1, 4);
    compose({0, 0, 2, 1}, behind, {{0, 0, 2, 1}, 3, rgba}, image);
    EXPECT_EQ(image.pixel(0, 0)[3], 85);
    EXPECT_EQ(image.pixel(0, 0)[0], 90);
    EXPECT_EQ(image.pixel(0, 0)[1], 0);
    EXPECT_EQ(image.pixel(1, 0)[3], 100);
    EXPECT_EQ(image.pixel(1, 0)[0], 128) << "50 / 100 of 255";
    EXPECT_EQ(image.pixel(1, 0)[1], 64);
}

TEST(Covered, IsWhereTheBoxIsSeen) {
    View view;
    view.eye = {0, -10, 0}, view.target = {0, 0, 0}, view.field_of_view = 90;
    const auto box_at = [&](float x, float y, float z) {
        const Eigen::Vector3f centre(x, y, z), half = Eigen::Vector3f::Constant(0.5F);
        return covered({centre - half, centre + half}, clip_from_eye(view, 0.1, 100) * eye_from_world(view), 200, 100, 1);
    };
    const PixelBox middle = box_at(0, 0, 0);  // 50 pixels are 10 m at a distance of 10 m: nearest face at 9.5 m
    EXPECT_NEAR(middle.x, 97 - 1, 1);
    EXPECT_NEAR(middle.width, 6 + 2, 1.01);
    EXPECT_NEAR(middle.y + middle.height / 2.0, 50, 1);
    EXPECT_GT(box_at(0, 0, 4).y, 55) << "up is up";
    EXPECT_TRUE(box_at(0, 0, 40).empty());
    EXPECT_EQ(box_at(0, -10, 0).width, 200) << "around the eye";
}

TEST(Surface, KnowsWhetherItIsClosed) {
    auto triangles = blob_frame(6)->model->triangles;
    EXPECT_TRUE(is_closed(triangles));
    EXPECT_TRUE(is_closed({}));
    auto open = triangles;
    open.pop_back();
    EXPECT_FALSE(is_closed(open));
    std::swap(triangles[3][0], triangles[3][1]);
    EXPECT_FALSE(is_closed(triangles)) << "a triangle that looks inward";
}

}  // namespace
}  // namespace tetfront
