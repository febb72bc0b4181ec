// `tetfront render`, the program itself.

#include "tests/support/child_process.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

constexpr const char* beam = R"({
  "schema_version": 1, "title": "A beam", "up": "z",
  "mesh": {"box": {"low": [0, 0, 0], "high": [4, 1, 1], "cells": [4, 1, 1]}},
  "levels": 1,
  "material": {"density": 1000, "poisson": 0.3, "young": 1e5},
  "pins": [{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}]
})";

class RenderCommand : public testing::Test {
 protected:
    RenderCommand() { scene_ = folder_.write("beam.json", beam).string(); }

    ChildProcess::Result run(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {TETFRONT_PROGRAM, "render", scene_});
        return ChildProcess(arguments).wait();
    }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

    TemporaryFolder folder_;
    std::string scene_;
};

TEST_F(RenderCommand, WritesASequenceAndSaysHowToMakeAVideo) {
    const auto result = run({"--frames", "3", "--size", "161x90", "--fps", "20", "--out", path("it's/frames"),
                             "--camera", "turntable", "--colour", "stiffness", "--wireframe"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.out.find("ffmpeg -framerate 20 -i '" + folder_.path().string() +
                              "/it'\\''s/frames/%06d.png' -frames:v 3 -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2'"),
              std::string::npos)
        << result.out;
    for (const char* name : {"000000.png", "000001.png", "000002.png"}) {
        const Image image = read_png(path("it's/frames/") + name);
        EXPECT_EQ(image.width, 161);
        EXPECT_EQ(image.height, 90);
    }
    EXPECT_FALSE(std::filesystem::exists(path("it's/frames/000003.png")));
    EXPECT_NE(result.err.find("frame 3/3"), std::string::npos) << "plain lines where there is no terminal";
    EXPECT_EQ(result.err.find('\r'), std::string::npos);

    std::ifstream in(path("it's/frames/000002.png"), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(bytes.find("A beam"), std::string::npos);
    EXPECT_NE(bytes.find(std::string("Scene\0beam", 10)), std::string::npos);
    EXPECT_NE(bytes.find(std::string("Time\0000.100000", 13)), std::string::npos) << "2 / 20 fps = 6 steps of 1/60 s";
}

TEST_F(RenderCommand, StartsWhereAskedAndFrameZeroIsBeforeAnyStep) {
    ASSERT_EQ(run({"--frames", "13", "--size", "160x90", "--out", path("all"), "--no-legend"}).status, 0);
    ASSERT_EQ(
        run({"--frames", "1", "--size", "160x90", "--out", path("late"), "--no-legend", "--start-at", "0.4"}).status,
        0);
    EXPECT_EQ(read_png(path("all/000012.png")).pixels, read_png(path("late/000000.png")).pixels);
    EXPECT_NE(read_png(path("all/000000.png")).pixels, read_png(path("late/000000.png")).pixels);
}

TEST_F(RenderCommand, RefusesBadInputWithStatusTwo) {
    const std::vector<std::vector<std::string>> cases = {
        {},
        {"--frames", "0"},
        {"--frames", "-3"},
        {"--frames", "many"},
        {"--frames", "1", "--size", "10x10"},
        {"--frames", "1", "--size", "99999x100"},
        {"--frames", "1", "--size", "640"},
        {"--frames", "1", "--size", "640x480x3"},
        {"--frames", "1", "--size", "99999999999999999999x10"},
        {"--frames", "1", "--fps", "0"},
        {"--frames", "1", "--fps", "nan"},
        {"--frames", "1", "--start-at", "-1"},
        {"--frames", "1", "--supersampling", "5"},
        {"--frames", "1", "--png-level", "10"},
        {"--frames", "1", "--colour", "rainbow"},
        {"--frames", "1", "--camera", "drone"},
        {"--frames", "1", "--set", "material.poisson=7"},
    };
    for (std::vector<std::string> arguments : cases) {
        arguments.insert(arguments.end(), {"--out", path("out")});
        const auto result = run(arguments);
        EXPECT_EQ(result.status, 2) << testing::PrintToString(arguments) << result.err;
        EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
        EXPECT_EQ(result.out, "");
    }
    EXPECT_FALSE(std::filesystem::exists(path("out"))) << "nothing is made for nothing";
}

TEST_F(RenderCommand, SaysWhenOutputCannotBeWrittenWithStatusFour) {
    folder_.write("file", "x");
    const auto result = run({"--frames", "1", "--out", path("file/frames")});
    EXPECT_EQ(result.status, 4);
    EXPECT_NE(result.err.find("file/frames"), std::string::npos) << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;

    std::filesystem::create_directories(path("frames/000001.png"));
    const auto late = run({"--frames", "3", "--size", "64x64", "--out", path("frames")});
    EXPECT_EQ(late.status, 4);
    EXPECT_NE(late.err.find("000001.png"), std::string::npos) << late.err;
    EXPECT_EQ(read_png(path("frames/000000.png")).width, 64) << "what came before is whole";
}

TEST_F(RenderCommand, StopsOnInterruptWithWholeFiles) {
    ChildProcess child(
        {TETFRONT_PROGRAM, "render", scene_, "--frames", "100000", "--size", "64x64", "--out", path("frames")});
    while (!std::filesystem::exists(path("frames/000003.png")))
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    child.signal(SIGINT);
    const auto result = child.wait();
    EXPECT_EQ(result.status, 130);
    EXPECT_NE(result.err.find("stopped after"), std::string::npos) << result.err;
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(path("frames"))) {
        EXPECT_NO_THROW(read_png(entry.path())) << entry;
        ++count;
    }
    EXPECT_TRUE(
        std::filesystem::exists(path("frames/") + (count > 9 ? "0000" : "00000") + std::to_string(count - 1) + ".png"));
}

}  // namespace
}  // namespace tetfront
