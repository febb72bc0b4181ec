// `tetfront render`, the program itself.

#include "tests/support/box_scene.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/project.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {
namespace {

class RenderCommand : public testing::Test {
 protected:
    RenderCommand() { scene_ = folder_.write("beam.json", box_scene_text).string(); }

    ChildProcess::Result run(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {program_path(), "render", scene_});
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
        {"--frames", "3-1"},
        {"--frames", "1-"},
        {"--frames", "-1-3"},
        {"--frames", "2000000"},
        {"--frames", "1-99999999999999999999"},
        {"--seconds", "0"},
        {"--frames", "1", "--every", "0"},
        {"--frames", "1", "--jobs", "2"},
        {"--frames", "1", "--range", "5"},
        {"--frames", "1", "--range", "2:1"},
        {"--frames", "1", "--camera", "keyframes"},
        {"--frames", "1", "--overlay", "fog"},
        {"--frames", "1", "--view", "missing.json"},
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
        {program_path(), "render", scene_, "--frames", "100000", "--size", "64x64", "--out", path("frames")});
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

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// File name -> bytes.
std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        files[entry.path().filename().string()] = bytes_of(entry.path());
    return files;
}

class RecordedRun : public RenderCommand {
 protected:
    void record(const std::string& frames, std::vector<std::string> more = {}) {
        std::vector<std::string> words = {program_path(), "record", scene_, "-o", path("run.tfr"), "--frames", frames};
        words.insert(words.end(), more.begin(), more.end());
        const auto result = ChildProcess(words).wait();
        ASSERT_EQ(result.status, 0) << result.err;
    }
    ChildProcess::Result render(const std::string& folder, std::vector<std::string> more) {
        std::vector<std::string> words = {program_path(), "render", path("run.tfr"), "--out", path(folder), "--size", "160x90"};
        words.insert(words.end(), more.begin(), more.end());
        return ChildProcess(words).wait();
    }
};

TEST_F(RecordedRun, ShowsWhatTheSimulationShows) {
    record("12", {"--colour", "stress"});
    ASSERT_EQ(render("replayed", {}).status, 0);
    ASSERT_EQ(run({"--frames", "12", "--size", "160x90", "--out", path("live"), "--colour", "stress", "--range", "0:1e6"}).status, 0);
    ASSERT_EQ(render("fixed", {"--range", "0:1e6"}).status, 0);
    EXPECT_EQ(contents(path("replayed")).size(), 12U);
    for (const char* name : {"000000.png", "000011.png"})
        EXPECT_LT(share_different(read_png(path("live/") + name), read_png(path("fixed/") + name), 8), 0.005) << name;
    const auto missing = render("other", {"--colour", "strain"});
    EXPECT_EQ(missing.status, 2);
    EXPECT_NE(missing.err.find("record it with --colour strain"), std::string::npos) << missing.err;
    EXPECT_EQ(render("other", {"--set", "levels=2"}).status, 2);
    EXPECT_EQ(render("other", {"--frames", "12-14"}).status, 2);
    EXPECT_EQ(render("other", {"--start-at", "9"}).status, 2);
    EXPECT_FALSE(std::filesystem::exists(path("other")));
}

TEST_F(RecordedRun, PartsAndJobsGiveTheSameBytes) {
    record("9");
    const std::vector<std::string> look = {"--camera", "turntable", "--wireframe"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.end(), look.begin(), look.end());
        return more;
    };
    ASSERT_EQ(render("one", with({})).status, 0);
    const auto two = render("two", with({"--jobs", "2"}));
    ASSERT_EQ(two.status, 0) << two.err;
    ASSERT_EQ(render("parts", with({"--frames", "5-8"})).status, 0);
    ASSERT_EQ(render("parts", with({"--frames", "0-4"})).status, 0);
    const auto one = contents(path("one"));
    EXPECT_EQ(one.size(), 9U);
    EXPECT_EQ(one, contents(path("two")));
    EXPECT_EQ(one, contents(path("parts")));
    ASSERT_EQ(render("third", {"--every", "3"}).status, 0);
    EXPECT_EQ(contents(path("third")).size(), 3U);
    ASSERT_EQ(render("plain", {}).status, 0);
    EXPECT_EQ(read_png(path("third/000002.png")).pixels, read_png(path("plain/000006.png")).pixels);
}

TEST_F(RecordedRun, ResumesAfterEveryKindOfEnd) {
    record("200");
    ASSERT_EQ(render("whole", {}).status, 0);
    const auto whole = contents(path("whole"));
    std::mt19937 random(5);
    int killed = 0;
    const auto made = [&] {
        std::error_code none;  // the folder comes with the first frame
        return std::distance(std::filesystem::directory_iterator(path("killed"), none), std::filesystem::directory_iterator());
    };
    for (int attempt = 0; attempt < 20; ++attempt) {  // SIGKILL at any moment
        if (made() > 150) std::filesystem::remove_all(path("killed"));
        // The folder has a file or two besides the frames.
        const auto enough = made() + static_cast<std::ptrdiff_t>(random() % 20);
        ChildProcess child({program_path(), "render", path("run.tfr"), "--out", path("killed"), "--size", "160x90", "--resume"});
        while (made() < enough) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 20'000));
        child.signal(SIGKILL);
        killed += child.wait().status == -SIGKILL;
        if (!std::filesystem::exists(path("killed"))) continue;
        for (const auto& [name, bytes] : contents(path("killed"))) {
            if (name.size() != 10) continue;
            EXPECT_EQ(bytes, whole.at(name)) << "under its final name a file is whole";
        }
    }
    EXPECT_GT(killed, 10);
    folder_.write("killed/000007.png.AbCdEf", "half");
    ASSERT_EQ(render("killed", {"--resume"}).status, 0);
    EXPECT_EQ(contents(path("killed")), whole) << "all frames, the same bytes, nothing else";

    std::filesystem::remove(path("killed/000003.png"));  // a hole in the middle, filled by two jobs
    std::filesystem::remove(path("killed/000031.png"));
    const auto hole = render("killed", {"--resume", "--jobs", "2", "--json"});
    ASSERT_EQ(hole.status, 0) << hole.err;
    EXPECT_NE(hole.out.find("\"missing\":2"), std::string::npos) << hole.out;
    EXPECT_EQ(contents(path("killed")), whole);

    const auto other = render("killed", {"--resume", "--wireframe"});
    EXPECT_EQ(other.status, 2) << "frames of two kinds in one directory";
    EXPECT_NE(other.err.find("other options"), std::string::npos) << other.err;
    ASSERT_EQ(render("killed", {"--resume"}).status, 0) << "nothing left to do";
}

TEST_F(RenderCommand, ASimulationResumesWithTheSameBytes) {
    const std::vector<std::string> options = {"--frames", "10", "--size", "96x64"};
    const auto to = [&](const std::string& folder, std::vector<std::string> more) {
        more.insert(more.end(), options.begin(), options.end());
        more.insert(more.end(), {"--out", path("x/" + folder + "/frames")});
        return run(more);
    };
    ASSERT_EQ(to("a", {}).status, 0);
    const auto whole = contents(path("x/a/frames"));
    std::filesystem::remove(path("x/a/frames/000004.png"));
    std::filesystem::remove(path("x/a/frames/000009.png"));
    ASSERT_EQ(to("a", {"--resume"}).status, 0);
    EXPECT_EQ(contents(path("x/a/frames")), whole);
}

TEST_F(RecordedRun, KilledRecordingIsReadable) {
    ChildProcess child({program_path(), "record", scene_, "-o", path("run.tfr"), "--frames", "100000"});
    for (int wait = 0; wait < 2000 && (!std::filesystem::exists(path("run.tfr")) || std::filesystem::file_size(path("run.tfr")) < 20000); ++wait)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    child.signal(SIGKILL);
    child.wait();
    const auto result = render("frames", {"--frames", "2"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("was cut short"), std::string::npos) << result.err;
}

TEST_F(RecordedRun, TellsProgramsInJson) {
    record("3");
    const auto result = render("frames", {"--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    std::istringstream lines(result.out);
    std::vector<nlohmann::json> events;
    for (std::string line; std::getline(lines, line);) events.push_back(nlohmann::json::parse(line));
    ASSERT_EQ(events.size(), 5U);
    EXPECT_EQ(events[0]["event"], "start");
    EXPECT_EQ(events[0]["frames"], 3);
    EXPECT_EQ(events[2]["frame"], 1);
    EXPECT_EQ(events[2]["file"], path("frames/000001.png"));
    EXPECT_EQ(events[4]["event"], "end");
    EXPECT_EQ(events[4]["written"], 3);
    EXPECT_EQ(result.err, "");
}

TEST_F(RecordedRun, MakesAVideoWhenThereIsFfmpeg) {
    record("2");
    const auto program = folder_.write("bin/ffmpeg", "#!/bin/sh\nfor word; do last=$word; done\necho \"$@\" > \"$last\"\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const auto with_path = [&](const std::string& search, const std::string& file) {
        return ChildProcess({"/usr/bin/env", "PATH=" + search, program_path(), "render", path("run.tfr"), "--out", path("frames"),
                             "--size", "64x64", "--video", file}).wait();
    };
    const auto made = with_path(path("bin") + ":/usr/bin:/bin", path("a.mp4"));
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_NE(bytes_of(path("a.mp4")).find("frames/%06d.png -frames:v 2 -c:v libx264"), std::string::npos);
    const auto none = with_path(path("frames"), path("b.mp4"));
    EXPECT_EQ(none.status, 0) << none.err;
    EXPECT_NE(none.out.find("There is no ffmpeg here"), std::string::npos) << none.out;
    folder_.write("bin/ffmpeg", "#!/bin/sh\nexit 3\n");
    const auto failed = with_path(path("bin") + ":/usr/bin:/bin", path("c.mp4"));
    EXPECT_EQ(failed.status, 4);
    EXPECT_NE(failed.err.find("exit status 3"), std::string::npos) << failed.err;
}

TEST_F(RenderCommand, ViewFileKeyframesAndOverlay) {
    const auto view = folder_.write("view.json", R"({"colouring": "strain", "range": [0, 0.1], "background": "dark",
        "keyframes": [{"time": 0, "eye": [3, -9, 2], "target": [2, 0, 0]}, {"time": 0.1, "eye": [9, -3, 4], "target": [2, 0, 0]}]})");
    ASSERT_EQ(run({"--frames", "4", "--size", "160x90", "--out", path("moving"), "--view", view.string(), "--camera", "keyframes"}).status, 0);
    ASSERT_EQ(run({"--frames", "4", "--size", "160x90", "--out", path("still"), "--view", view.string(), "--overlay", "none"}).status, 0);
    EXPECT_GT(share_different(read_png(path("moving/000000.png")), read_png(path("moving/000003.png")), 40), 0.03);
    EXPECT_EQ(read_png(path("still/000000.png")).pixel(1, 1)[0], read_png(path("moving/000000.png")).pixel(1, 1)[0]);
    const auto bad = folder_.write("bad.json", R"({"colour": "strain"})");
    const auto refused = run({"--frames", "1", "--out", path("none"), "--view", bad.string()});
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("bad.json: /colour"), std::string::npos) << refused.err;
}

TEST_F(RenderCommand, AnotherUsersDirectoryAndAFullDiskAreStatusFour) {
    const auto result = ChildProcess({program_path(), "record", scene_, "-o", "/dev/full", "--frames", "1"}).wait();
    EXPECT_EQ(result.status, 4);
    EXPECT_NE(result.err.find("/dev/full"), std::string::npos) << result.err;
    EXPECT_EQ(ChildProcess({program_path(), "record", scene_, "-o", path("no/run.tfr"), "--frames", "1"}).wait().status, 4);
    EXPECT_EQ(run({"--frames", "1", "--out", "/proc/frames"}).status, 4);
    // A limit on the size of files ends a picture in the middle, as a full disk does.
    const auto full = ChildProcess({"/bin/sh", "-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" render \"$1\" --frames 2 --size 640x360 --out \"$2\"",
                                    program_path(), scene_, path("full")}).wait();
    EXPECT_EQ(full.status, 4) << full.err;
    EXPECT_NE(full.err.find("000000.png"), std::string::npos) << full.err;
    EXPECT_TRUE(contents(path("full")).empty()) << "nothing half-written under any name";
}

}  // namespace
}  // namespace tetfront
