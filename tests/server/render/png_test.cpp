#include "server/render/png.hpp"

#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

Image noise(int width, int height, int channels) {
    Image image(width, height, channels);
    std::mt19937 random(3);
    for (std::uint8_t& x : image.pixels) x = static_cast<std::uint8_t>(random());
    return image;
}

/// Chunk type -> contents, in order of appearance.
std::multimap<std::string, std::string> chunks(const std::string& png) {
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    std::multimap<std::string, std::string> found;
    for (std::size_t at = 8; at + 12 <= png.size();) {
        std::size_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<unsigned char>(png[at + i]);
        found.emplace(png.substr(at + 4, 4), png.substr(at + 8, length));
        at += 12 + length;
    }
    return found;
}

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Png, ComesBackAsItWas) {
    const TemporaryFolder folder;
    for (const int channels : {3, 4}) {
        for (const int level : {0, 1, 9}) {
            const Image image = noise(37, 23, channels);
            write_atomically(folder.path() / "a.png", encode_png(image, {.level = level}));
            const Image back = read_png(folder.path() / "a.png");
            EXPECT_EQ(back.width, 37);
            EXPECT_EQ(back.height, 23);
            EXPECT_EQ(back.channels, channels);
            EXPECT_EQ(back.pixels, image.pixels);
        }
    }
}

TEST(Png, SaysWhatMadeIt) {
    const auto found = chunks(encode_png(
        noise(8, 8, 3), {.level = 1, .text = {{"Software", "tetfront 0.1"}, {"Title", "Häschen"}, {"Frame", "12"}}}));
    EXPECT_EQ(found.count("sRGB"), 1U);
    EXPECT_EQ(found.count("IEND"), 1U);
    std::vector<std::string> plain;
    for (auto [i, end] = found.equal_range("tEXt"); i != end; ++i) plain.push_back(i->second);
    EXPECT_EQ(plain,
              (std::vector<std::string>{std::string("Software\0tetfront 0.1", 21), std::string("Frame\00012", 8)}));
    ASSERT_EQ(found.count("iTXt"), 1U) << "text beyond ASCII is UTF-8";
    EXPECT_NE(found.find("iTXt")->second.find("Häschen"), std::string::npos);
}

TEST(Png, SmallerWithMoreWork) {
    Image image(300, 200, 3);
    for (int i = 0; i < 300 * 200; ++i)
        image.pixel(i % 300, i / 300)[0] = static_cast<std::uint8_t>(i % 300 / 2 + i / 900);
    EXPECT_LT(encode_png(image, {.level = 9}).size(), encode_png(image, {.level = 1}).size());
    EXPECT_LT(encode_png(image, {.level = 1}).size(), image.pixels.size() / 4);
    EXPECT_EQ(encode_png(image, {}), encode_png(image, {}));
}

TEST(Png, ItsTextIsFoundAgain) {
    const TemporaryFolder folder;
    const auto file = folder.write(
        "a.png", encode_png(noise(8, 8, 3), {.level = 1, .text = {{"Software", "tetfront 0.1"}, {"Settings", "1f"}}}));
    EXPECT_EQ(read_png_text(file, "Settings"), "1f");
    EXPECT_EQ(read_png_text(file, "Software"), "tetfront 0.1");
    EXPECT_EQ(read_png_text(file, "Soft"), "");
    EXPECT_EQ(read_png_text(folder.path() / "missing.png", "Settings"), "");
    for (const std::size_t length : {0U, 7U, 8U, 20U, 40U})
        EXPECT_EQ(read_png_text(folder.write("cut.png", read(file).substr(0, length)), "Settings"), "");
    EXPECT_EQ(read_png_text(folder.write("huge.png", read(file).substr(0, 8) + "\xff\xff\xff\xfftEXtSettings"), "Settings"), "");
}

}  // namespace
}  // namespace tetfront
