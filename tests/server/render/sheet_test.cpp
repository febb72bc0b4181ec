#include "server/render/sheet.hpp"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

namespace tetfront {
namespace {

Image plain(int width, int height, std::uint8_t value) {
    Image image(width, height, 3);
    std::ranges::fill(image.pixels, value);
    return image;
}

TEST(ContactSheet, PutsImagesRowByRowWithWhiteBetween) {
    Image sheet = contact_sheet({plain(4, 3, 10), plain(4, 3, 20), plain(4, 3, 30)}, 2, 2);
    EXPECT_EQ(sheet.width, 10);
    EXPECT_EQ(sheet.height, 8);
    const auto at = [&](int x, int y) { return int{*sheet.pixel(x, y)}; };
    EXPECT_EQ((std::array{at(0, 0), at(3, 2), at(4, 0), at(6, 0), at(9, 2)}), (std::array{10, 10, 255, 20, 20}));
    EXPECT_EQ((std::array{at(0, 3), at(0, 5), at(3, 7), at(6, 5)}), (std::array{255, 30, 30, 255})) << "the last place is empty";
    EXPECT_EQ(contact_sheet({plain(4, 3, 1)}, 5).width, 4);
}

TEST(ContactSheet, WantsImagesOfOneSize) {
    EXPECT_THROW(contact_sheet({}, 2), LogicError);
    EXPECT_THROW(contact_sheet({plain(4, 3, 1), plain(3, 4, 1)}, 2), LogicError);
}

}  // namespace
}  // namespace tetfront
