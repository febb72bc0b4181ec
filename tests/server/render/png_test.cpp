#include "server/render/png.hpp"

#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <sys/resource.h>

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

std::size_t files_in(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Png, ComesBackAsItWas) {
    const TemporaryFolder folder;
    for (const int channels : {3, 4}) {
        for (const int level : {0, 1, 9}) {
            const Image image = noise(37, 23, channels);
            write_file(folder.path() / "a.png", encode_png(image, {.level = level}));
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

TEST(WriteFile, ReplacesAndLeavesNothingElse) {
    const TemporaryFolder folder;
    write_file(folder.path() / "a", "one");
    write_file(folder.path() / "a", "two");
    EXPECT_EQ(read(folder.path() / "a"), "two");
    EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(WriteFile, NamesTheFileThatCannotBeWritten) {
    const TemporaryFolder folder;
    folder.write("file", "x");
    std::filesystem::create_directory(folder.path() / "directory");
    for (const char* name : {"file/a.png", "missing/a.png", "directory"}) {
        try {
            write_file(folder.path() / name, "bytes");
            ADD_FAILURE() << name << " was written";
        } catch (const WriteError& error) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
        }
    }
    EXPECT_EQ(files_in(folder.path()), 2U);
    EXPECT_THROW(prepare_directory(folder.path() / "file" / "below"), WriteError);
    prepare_directory(folder.path() / "new" / "below");
    EXPECT_EQ(files_in(folder.path() / "new" / "below"), 0U);
}

TEST(WriteFile, KeepsTheOldFileWhenTheDiskIsFull) {
    const TemporaryFolder folder;
    write_file(folder.path() / "a", "old");
    // A limit on the size of files fails in the middle of a write, as a full disk does.
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1000, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(write_file(folder.path() / "a", std::string(5000, 'x')), WriteError);
    EXPECT_THROW(write_file(folder.path() / "b", std::string(5000, 'x')), WriteError);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(read(folder.path() / "a"), "old");
    EXPECT_EQ(files_in(folder.path()), 1U) << "neither a half-written nor a temporary file";
}

}  // namespace
}  // namespace tetfront
