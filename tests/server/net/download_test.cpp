// What the server has drawn by processes of its own: the pictures and the video of a recording, the scenes' thumbnails.

#include "server/net/child_output.hpp"
#include "server/net/exports.hpp"
#include "server/session/recording.hpp"
#include "tests/server/net/client.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/project.hpp"

#include <csignal>
#include <cstdlib>
#include <future>

#include <sys/resource.h>

namespace tetfront {
namespace {

class DownloadTest : public ServerTest {
 protected:
    DownloadTest() {
        child_program() = program_path();
        scenes_.write("small.json", R"({"schema_version": 1, "up": "z", "title": "Small",
            "mesh": {"box": {"low": [0, 0, 0], "high": [1, 1, 1], "cells": [1, 1, 1]}}, "levels": 1,
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5}, "view": {"colouring": "stress"}})");
        scenes_.write("bad.json", R"({"schema_version": 1, "up": "z", "mesh": {"surface": {"file": "missing.obj"}}, "levels": 1,
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5}})");
    }
    ~DownloadTest() override {
        stop();
        ::setenv("PATH", path_.c_str(), 1);
    }
    void start_with_library() { start(false, {}, box_scene(), {.library = Library(scenes_.path(), data_.path()), .recording_bytes = 1 << 24}); }
    void record(int frames) {
        Client client(connect(), host());
        ASSERT_EQ(client.command({{"id", 1}, {"command", "record_start"}, {"name", "run"}, {"fps", 60}})["type"], "ok");
        client.send(Json({{"id", 2}, {"command", "step"}, {"count", frames - 1}}).dump());
        client.until([&](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == frames - 1; });
        ASSERT_EQ(client.command({{"id", 3}, {"command", "record_stop"}})["type"], "ok");
        ASSERT_EQ(Recording(data_.path() / "recordings" / "run.tfr").frame_count(), static_cast<std::size_t>(frames));
    }
    /// From now on this runs instead of our own program. $0.NAME are files of its own.
    std::filesystem::path run_instead(const std::string& script) {
        const auto file = programs_.write("program", "#!/bin/sh\n" + script + "\n");
        std::filesystem::permissions(file, std::filesystem::perms::owner_all);
        child_program() = file.string();
        return file;
    }
    /// Waits until the program has written this file of its own.
    std::string file_of(const std::filesystem::path& program, const char* name) {
        std::string text;
        for (int wait = 0; wait < 500 && !text.ends_with('\n'); ++wait) {
            std::this_thread::sleep_for(20ms);
            std::ifstream in(program.string() + "." + name);
            text = {std::istreambuf_iterator<char>(in), {}};
        }
        return text;
    }
    /// Programs are looked for in this folder alone.
    void only_programs_of(const std::filesystem::path& folder) { ::setenv("PATH", folder.c_str(), 1); }

    TemporaryFolder scenes_, data_, programs_;
    const std::string path_ = std::getenv("PATH") ? std::getenv("PATH") : "";
};

TEST_F(DownloadTest, ARecordingComesAsPicturesInAZipFile) {
    start_with_library();
    record(5);
    const auto zip = request(http::verb::get, "/recordings/run.tfr/frames.zip?w=64&h=48&view=%7B%22background%22%3A%22dark%22%7D");
    ASSERT_EQ(zip.result_int(), 200U) << zip.body();
    EXPECT_EQ(zip[http::field::content_type], "application/zip");
    EXPECT_EQ(zip[http::field::content_disposition], "attachment; filename=\"run.zip\"");
    const auto file = data_.write("unpacked/run.zip", zip.body());
    ASSERT_EQ(ChildProcess({"/usr/bin/env", "-C", file.parent_path().string(), "cmake", "-E", "tar", "xf", "run.zip"}).wait().status, 0);
    for (const char* name : {"000000.png", "000004.png"}) {
        const Image image = read_png(file.parent_path() / name);
        EXPECT_EQ(image.width, 64);
        EXPECT_EQ(image.height, 48);
        EXPECT_LT(image.pixel(0, 0)[0], 100) << "as the view says";
    }
    EXPECT_FALSE(std::filesystem::exists(file.parent_path() / "000005.png"));
    const auto moving = find_export(Library({}, data_.path()), "/recordings/run.tfr/frames.zip",
                                    "view=%7B%22keyframes%22%3A%5B%7B%22time%22%3A0%2C%22eye%22%3A%5B9%2C0%2C0%5D%2C%22target%22%3A%5B0%2C0%2C0%5D%7D%5D%7D");
    ASSERT_TRUE(moving);
    EXPECT_EQ(moving->words.back(), "keyframes") << "the camera moves as the view says";
    const auto threads = std::ranges::find(moving->words, "--threads");
    ASSERT_LT(threads, moving->words.end() - 1);
    EXPECT_EQ(threads[1], "1") << "the simulation wants the others";
    // What the server tells does not change what is on its disk.
    EXPECT_EQ(Library({}, data_.path()).recordings().size(), 1U);
}

TEST_F(DownloadTest, WrongRequestsAreRefusedWithTheirReason) {
    start_with_library();
    record(2);
    EXPECT_EQ(request(http::verb::get, "/recordings/none.tfr/frames.zip").result_int(), 404U);
    EXPECT_EQ(request(http::verb::get, "/recordings/..%2Frun.tfr/frames.zip").result_int(), 404U);
    EXPECT_EQ(request(http::verb::get, "/recordings/run.tfr/frames.tar").result_int(), 404U);
    for (const char* query : {"w=1", "h=99999", "view=%7B", "view=%7B%22colour%22%3A1%7D", "view=--json", "x=1"})
        EXPECT_EQ(request(http::verb::get, std::string("/recordings/run.tfr/frames.zip?") + query).result_int(), 400U) << query;
    const auto other = request(http::verb::get, "/recordings/run.tfr/frames.zip?view=%7B%22colouring%22%3A%22strain%22%7D");
    EXPECT_EQ(other.result_int(), 422U);
    EXPECT_NE(other.body().find("was not recorded"), std::string::npos) << other.body();
    EXPECT_EQ(std::ranges::count(other.body(), '\n'), 1) << other.body();
    EXPECT_EQ(other.body().find('/'), std::string::npos) << "where it lies is nobody's business: " << other.body();
    // Blanks before the JSON are none of a file's name.
    EXPECT_EQ(request(http::verb::get, "/recordings/run.tfr/frames.zip?w=64&h=48&view=%20%7B%7D").result_int(), 200U);
    EXPECT_EQ(exchange("GET /recordings/run.tfr/frames.zip HTTP/1.0\r\nHost: " + host() + "\r\n\r\n").substr(9, 3), "505");
}

TEST_F(DownloadTest, AVideoIsMadeByFfmpegWhereThereIsOne) {
    const TemporaryFolder programs;
    only_programs_of(programs.path());
    start_with_library();
    record(3);
    const auto offered = [&] {
        Client client(connect(), host());
        return client.command({{"id", 1}, {"command", "recordings"}})["video"].get<bool>();
    };
    EXPECT_FALSE(offered());
    const auto none = request(http::verb::get, "/recordings/run.tfr/video.mp4?w=64&h=48");
    EXPECT_EQ(none.result_int(), 422U);
    EXPECT_NE(none.body().find("there is no ffmpeg here"), std::string::npos) << none.body();
    const auto ffmpeg = programs.write("ffmpeg", "#!/bin/sh\necho \"$@\"\n/bin/cat\n");
    std::filesystem::permissions(ffmpeg, std::filesystem::perms::owner_all);
    EXPECT_TRUE(offered());
    const auto video = request(http::verb::get, "/recordings/run.tfr/video.mp4?w=64&h=48");
    EXPECT_EQ(video.result_int(), 200U);
    EXPECT_EQ(video[http::field::content_type], "video/mp4");
    EXPECT_EQ(video.body().find("-loglevel error -f image2pipe -c:v png -framerate 60 -i pipe:0 -c:v libx264"), 0U) << video.body().substr(0, 200);
    std::size_t pictures = 0;
    for (std::size_t at = 0; (at = video.body().find("\x89PNG", at)) != std::string::npos; ++at) ++pictures;
    EXPECT_EQ(pictures, 3U) << "it was given all of them";
}

TEST_F(DownloadTest, AreBoundedAndEndWithTheirClient) {
    start_with_library();
    record(400);
    const std::string ask = "GET /recordings/run.tfr/frames.zip?w=1024&h=768 HTTP/1.1\r\nHost: " + host() + "\r\n\r\n";
    {
        std::vector<tcp::socket> readers;
        for (int i = 0; i < 2; ++i) {
            readers.push_back(connect());
            asio::write(readers.back(), asio::buffer(ask));
        }
        for (tcp::socket& reader : readers) {  // both have begun
            std::array<char, 12> start{};
            asio::read(reader, asio::buffer(start));
            EXPECT_EQ(std::string(start.data(), start.size()), "HTTP/1.1 200");
        }
        EXPECT_EQ(request(http::verb::get, "/recordings/run.tfr/frames.zip").result_int(), 429U);
        EXPECT_EQ(request(http::verb::get, "/readyz").result_int(), 200U) << "the server itself is not busy";
    }
    // Their processes end with the next picture that nobody takes; then there is room again.
    std::string answer;
    for (int wait = 0; wait < 600 && answer.find(" 200 ") == std::string::npos; ++wait) {
        std::this_thread::sleep_for(50ms);
        tcp::socket reader = connect();
        asio::write(reader, asio::buffer(ask));
        answer.resize(15);
        asio::read(reader, asio::buffer(answer));
    }
    EXPECT_NE(answer.find(" 200 "), std::string::npos) << answer;
    tcp::socket again = connect();
    asio::write(again, asio::buffer(ask));
    stop();  // while it is being drawn: returns
}

TEST_F(DownloadTest, TheHeadOfADownloadIsThatOfTheDownload) {
    start_with_library();
    record(2);
    const std::string rest = " HTTP/1.1\r\nHost: " + host() + "\r\n";
    const std::string answers = exchange("HEAD /recordings/run.tfr/frames.zip" + rest + "\r\nGET /healthz" + rest + "Connection: close\r\n\r\n");
    const std::string head = answers.substr(0, answers.find("\r\n\r\n") + 4), next = answers.substr(head.size());
    EXPECT_EQ(head.substr(0, 12), "HTTP/1.1 200");
    EXPECT_NE(head.find("application/zip"), std::string::npos) << head;
    EXPECT_NE(head.find("Transfer-Encoding: chunked"), std::string::npos) << head;
    EXPECT_EQ(head.find("Content-Length"), std::string::npos) << "nobody knows it: " << head;
    EXPECT_EQ(next.substr(0, 12), "HTTP/1.1 200") << "nothing but the header was sent: " << next;
}

TEST_F(DownloadTest, AClientThatLeavesWhileNothingComesEndsTheProcess) {
    start_with_library();
    record(2);
    const auto program = run_instead("echo $$ > $0.process; exec sleep 1000");
    pid_t process = 0;
    {
        tcp::socket reader = connect();
        asio::write(reader, asio::buffer("GET /recordings/run.tfr/frames.zip HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"));
        process = std::stoi("0" + file_of(program, "process"));
        ASSERT_GT(process, 0);
        EXPECT_EQ(::kill(process, 0), 0);
    }
    for (int wait = 0; wait < 500 && ::kill(process, 0) == 0; ++wait) std::this_thread::sleep_for(20ms);
    EXPECT_NE(::kill(process, 0), 0);
}

TEST_F(DownloadTest, ARequestBehindADownloadIsAnsweredAfterIt) {
    start_with_library();
    record(2);
    run_instead("sleep 0.3; echo drawn");
    const std::string rest = " HTTP/1.1\r\nHost: " + host() + "\r\n";
    const std::string answers = exchange("GET /recordings/run.tfr/frames.zip" + rest + "\r\nGET /healthz" + rest + "Connection: close\r\n\r\n");
    const std::size_t drawn = answers.find("\r\n\r\n6\r\ndrawn\n\r\n0\r\n\r\nHTTP/1.1 200");
    EXPECT_NE(drawn, std::string::npos) << answers;
    EXPECT_EQ(answers.substr(answers.size() - 3), "ok\n");
}

TEST_F(DownloadTest, WhatAProcessSaysHoldsItNotUpAndItsLastLineIsTheReason) {
    start_with_library();
    record(2);
    const std::string talk = "head -c 300000 /dev/zero | tr '\\0' x >&2; echo >&2; ";
    run_instead(talk + "echo drawn");
    EXPECT_EQ(request(http::verb::get, "/recordings/run.tfr/frames.zip").body(), "drawn\n");
    run_instead(talk + "echo there is no more >&2; exit 2");
    const auto refused = request(http::verb::get, "/recordings/run.tfr/frames.zip");
    EXPECT_EQ(refused.result_int(), 422U);
    EXPECT_EQ(refused.body(), "there is no more\n");
}

TEST_F(DownloadTest, AProcessThatTakesLongToEndHoldsNobodyUp) {
    start_with_library();
    record(2);
    const auto program = run_instead("echo drawn; exec >&-; echo >$0.drawn; until [ -e $0.end ]; do sleep 0.02; done; exit 3");
    tcp::socket reader = connect();
    asio::write(reader, asio::buffer("GET /recordings/run.tfr/frames.zip HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"));
    file_of(program, "drawn");
    auto other = std::async(std::launch::async, [&] { return request(http::verb::get, "/readyz").result_int(); });
    EXPECT_EQ(other.wait_for(10s), std::future_status::ready);
    programs_.write("program.end", "");
    EXPECT_EQ(other.get(), 200U);
    std::string answer;
    Error error;
    asio::read(reader, asio::dynamic_buffer(answer), error);
    EXPECT_TRUE(answer.ends_with("6\r\ndrawn\n\r\n")) << "and without its end, as the process has failed: " << answer;
}

TEST_F(DownloadTest, TheSimulationGoesFirst) {
    start_with_library();
    record(2);
    run_instead("sleep 0.2; nice");
    const int mine = ::getpriority(PRIO_PROCESS, 0);
    EXPECT_EQ(request(http::verb::get, "/recordings/run.tfr/frames.zip").body(), std::to_string(std::min(19, mine + 10)) + "\n");
}

TEST_F(DownloadTest, OnlyWhatIsWrongWithASceneIsRemembered) {
    start_with_library();
    const auto program = run_instead("echo $2 >> $0.starts; if [ $(wc -l < $0.starts) = 1 ]; then kill -9 $$; fi; exec " + program_path() + " \"$@\"");
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").result_int(), 204U) << "it was killed";
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").result_int(), 200U) << "not this time";
    for (int i = 0; i < 2; ++i) EXPECT_EQ(request(http::verb::get, "/thumbnails/bad.png").result_int(), 204U);
    const std::string starts = file_of(program, "starts");
    EXPECT_EQ(std::ranges::count(starts, '\n'), 3) << "the bad one is not tried again: " << starts;
}

TEST_F(DownloadTest, AThumbnailThatCannotBeReadIsDrawnAgain) {
    std::filesystem::create_directories(data_.path() / "thumbnails" / "small.png");
    start_with_library();
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").result_int(), 200U);
}

TEST_F(DownloadTest, ScenesHaveThumbnailsThatAreKept) {
    start_with_library();
    const auto made = request(http::verb::get, "/thumbnails/small.png");
    ASSERT_EQ(made.result_int(), 200U) << made.body();
    EXPECT_EQ(made[http::field::content_type], "image/png");
    const Image image = read_png(data_.write("seen.png", made.body()));
    EXPECT_EQ(image.width, 320);
    EXPECT_EQ(image.height, 200);
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").body(), made.body());
    EXPECT_EQ(request(http::verb::get, "/thumbnails/bad.png").result_int(), 204U) << "its mesh is missing";
    EXPECT_EQ(request(http::verb::get, "/thumbnails/none.png").result_int(), 404U);
    EXPECT_EQ(request(http::verb::get, "/thumbnails/..%2Fsmall.png").result_int(), 404U);
    EXPECT_EQ(request(http::verb::get, "/thumbnails/").result_int(), 404U);
    const auto kept = data_.path() / "thumbnails" / "small.png";
    ASSERT_TRUE(std::filesystem::exists(kept));
    stop();

    std::ofstream(kept) << "kept";
    start_with_library();
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").body(), "kept") << "another server does not draw it again";
    std::filesystem::last_write_time(scenes_.path() / "small.json", std::filesystem::file_time_type::clock::now() + 10s);
    EXPECT_EQ(request(http::verb::get, "/thumbnails/small.png").body(), made.body()) << "the scene has changed since";
}

TEST(Exports, PathsAreExactly) {
    EXPECT_TRUE(is_export("/recordings/a.tfr/frames.zip"));
    EXPECT_TRUE(is_export("/recordings/a.tfr/video.mp4"));
    for (const char* path : {"/recordings/a.tfr", "/recordings/frames.zip", "/recordings//frames.zip", "/scenes/a/frames.zip", "/frames.zip", ""})
        EXPECT_FALSE(is_export(path)) << path;
}

}  // namespace
}  // namespace tetfront
