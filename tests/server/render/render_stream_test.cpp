// `tetfront render --stdout`, and what it does where the rasteriser is missing.

#include "tests/support/box_scene.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/project.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

class RenderStream : public testing::Test {
 protected:
    RenderStream() { scene_ = folder_.write("beam.json", box_scene_text).string(); }
    ChildProcess::Result render(std::vector<std::string> more, std::vector<std::string> before = {}) {
        std::vector<std::string> words = std::move(before);
        words.insert(words.end(), {program_path(), "render", scene_, "--frames", "3", "--size", "96x64"});
        words.insert(words.end(), more.begin(), more.end());
        return ChildProcess(words).wait();
    }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    std::string bytes_of(const std::string& name) {
        std::ifstream in(path(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    TemporaryFolder folder_;
    std::string scene_;
};

TEST_F(RenderStream, TheZipFileHoldsTheFilesOfTheDirectory) {
    ASSERT_EQ(render({"--out", path("frames")}).status, 0);
    const auto zip = render({"--stdout", "zip"});
    ASSERT_EQ(zip.status, 0) << zip.err;
    const auto file = folder_.write("unpacked/all.zip", zip.out);
    ASSERT_EQ(ChildProcess({"/usr/bin/env", "-C", file.parent_path().string(), "cmake", "-E", "tar", "xf", "all.zip"}).wait().status, 0);
    for (const char* name : {"000000.png", "000001.png", "000002.png"}) {
        EXPECT_FALSE(bytes_of(std::string("frames/") + name).empty());
        EXPECT_EQ(bytes_of(std::string("unpacked/") + name), bytes_of(std::string("frames/") + name)) << name;
    }
    EXPECT_EQ(render({"--stdout", "png"}).out, bytes_of("frames/000000.png") + bytes_of("frames/000001.png") + bytes_of("frames/000002.png"));
}

TEST_F(RenderStream, TakesTheViewAsItsArgument) {
    const auto dark = render({"--stdout", "png", "--view", R"({"background": "dark", "legend": false})"});
    ASSERT_EQ(dark.status, 0) << dark.err;
    // Of the three, one after the other, this reads the first.
    EXPECT_LT(read_png(folder_.write("dark.png", dark.out)).pixel(0, 0)[0], 100);
    const auto bad = render({"--stdout", "png", "--view", "{\"fog\": 1}"});
    EXPECT_EQ(bad.status, 2);
    EXPECT_NE(bad.err.find("--view: /fog"), std::string::npos) << bad.err;
}

TEST_F(RenderStream, WhatBelongsToADirectoryIsRefused) {
    for (const std::vector<std::string>& more : {std::vector<std::string>{"--resume"}, {"--json"}, {"--video", "a.mp4"}}) {
        std::vector<std::string> words = {"--stdout", "zip"};
        words.insert(words.end(), more.begin(), more.end());
        const auto result = render(words);
        EXPECT_EQ(result.status, 2) << more[0];
        EXPECT_EQ(result.out, "");
        EXPECT_NE(result.err.find(more[0]), std::string::npos) << result.err;
    }
    EXPECT_EQ(render({"--stdout", "tar"}).status, 2);
}

TEST_F(RenderStream, MorePicturesThanAZipFileHoldsAreRefusedBeforeTheFirst) {
    const auto result = ChildProcess({program_path(), "render", scene_, "--frames", "65536", "--size", "96x64", "--stdout", "zip"}).wait();
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find("65,535 files"), std::string::npos) << result.err;
}

TEST_F(RenderStream, AReaderThatLeavesIsStatusFour) {
    const auto result = ChildProcess({"/bin/sh", "-c", "\"$0\" render \"$1\" --frames 500 --size 640x360 --stdout zip | head -c 100 > /dev/null",
                                      program_path(), scene_}).wait();
    EXPECT_NE(result.err.find("standard output cannot be written"), std::string::npos) << result.err;
    const auto full = ChildProcess({program_path(), "render", scene_, "--frames", "3", "--size", "96x64", "--stdout", "zip"}, "/dev/full").wait();
    EXPECT_EQ(full.status, 4) << full.err;
}

TEST_F(RenderStream, WithoutFfmpegThereIsNoVideo) {
    const auto none = render({"--stdout", "mp4"}, {"/usr/bin/env", "PATH=" + path("nowhere")});
    EXPECT_EQ(none.status, 4);
    EXPECT_NE(none.err.find("there is no ffmpeg here"), std::string::npos) << none.err;
    const auto ffmpeg = folder_.write("bin/ffmpeg", "#!/bin/sh\n/bin/cat > /dev/null\nexit 7\n");
    std::filesystem::permissions(ffmpeg, std::filesystem::perms::owner_all);
    const auto failed = render({"--stdout", "mp4"}, {"/usr/bin/env", "PATH=" + path("bin")});
    EXPECT_EQ(failed.status, 4);
    EXPECT_NE(failed.err.find("ffmpeg failed, exit status 7"), std::string::npos) << failed.err;
}

TEST_F(RenderStream, AMissingRasteriserIsOneClearError) {
    folder_.write("libOSMesa.so.8", "");  // found first, and no library
    const auto result = render({"--out", path("frames")}, {"/usr/bin/env", "LD_LIBRARY_PATH=" + folder_.path().string()});
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("OSMesa: cannot be loaded"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("libosmesa6"), std::string::npos) << "what to install: " << result.err;
    EXPECT_TRUE(std::filesystem::is_empty(path("frames")));
    const auto without_pictures = ChildProcess({"/usr/bin/env", "LD_LIBRARY_PATH=" + folder_.path().string(), program_path(), "info", scene_}).wait();
    EXPECT_EQ(without_pictures.status, 0) << without_pictures.err;
}

}  // namespace
}  // namespace tetfront
