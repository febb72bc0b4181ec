// What goes wrong around a server that runs for long: signals, disks that fill, clients that freeze or vanish. Those that
// need a process of its own run the program.

#include "tests/server/net/client.hpp"
#include "tests/support/server_process.hpp"

#include "server/session/recording.hpp"

#include <atomic>
#include <csignal>

#include <linux/filter.h>
#include <sys/socket.h>
#include <sys/wait.h>

namespace tetfront {
namespace {

const auto is_frame = [](const Message& m) { return m.type() == 3; };

bool viewers_are(const Message& m, int count) { return m.text && m.json["type"] == "state" && m.json["viewers"] == count; }

/// Clients of the program itself.
class ServerProcessTest : public testing::Test {
 protected:
    ServerProcessTest() {
        scene_ = folder_.write("beam.json", R"({
            "schema_version": 1, "title": "A beam", "up": "z", "levels": 1,
            "mesh": {"box": {"low": [0, 0, 0], "high": [4, 1, 1], "cells": [4, 1, 1]}},
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5},
            "pins": [{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}]})").string();
        web_ = folder_.write("web/index.html", "<!doctype html>").parent_path().string();
    }
    ServerProcess serve(const std::vector<std::string>& more = {}, int most_blocks = 0) {
        std::vector<std::string> arguments = {scene_, "--web", web_, "--no-cache", "--data", (folder_.path() / "data").string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return ServerProcess(arguments, most_blocks);
    }
    tcp::socket connect(const ServerProcess& server) {
        tcp::socket socket(io_);
        socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
        return socket;
    }

    TemporaryFolder folder_;
    std::string scene_, web_;
    asio::io_context io_;
};

TEST_F(ServerProcessTest, SignalsOfTerminalsPipesAndLimitsDoNotEndIt) {
    ServerProcess server = serve();
    Client client(connect(server), server.host());
    for (const int signal : {SIGHUP, SIGPIPE, SIGXFSZ}) {
        server.signal(signal);
        EXPECT_EQ(client.command({{"id", signal}, {"command", "pause"}})["type"], "ok") << signal;
    }
    server.signal(SIGTERM);
    EXPECT_EQ(client.closed(), 1001);
    EXPECT_EQ(server.wait().status, 0);
}

TEST_F(ServerProcessTest, SigtermEndsItUnderLoad) {
    ServerProcess server = serve();
    std::vector<std::thread> readers;
    std::atomic<int> watching = 0, told = 0;
    for (int i = 0; i < 8; ++i)
        readers.emplace_back([&, socket = connect(server)]() mutable {
            Client client(std::move(socket), server.host());
            client.until(is_frame);
            ++watching;
            told += client.closed() == 1001;
        });
    // One that has stopped reading, with answers and frames piling up, one in the middle of a message, one of a request.
    Client deaf(connect(server), server.host());
    deaf.until(is_frame);
    for (int i = 0; i < 500; ++i) deaf.send("?");
    Client slow(connect(server), server.host());
    slow.stream().write_some(false, asio::buffer(std::string_view("{\"id\"")));
    tcp::socket half = connect(server);
    asio::write(half, asio::buffer(std::string_view("GET / HTTP/1.1\r\nHos")));
    while (watching < 8) std::this_thread::sleep_for(5ms);
    server.signal(SIGTERM);
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(told, 8);
    EXPECT_EQ(server.wait().status, 0);
}

TEST_F(ServerProcessTest, SigtermEndsItInTheMiddleOfABuild) {
    // A build of seconds.
    scene_ = folder_.write("large.json", R"({"schema_version": 1, "up": "z", "levels": 1,
        "mesh": {"box": {"low": [0, 0, 0], "high": [1, 1, 1], "cells": [24, 24, 24]}},
        "material": {"density": 1000, "poisson": 0.3, "young": 1e5}})").string();
    ServerProcess server = serve();
    Client client(connect(server), server.host());
    client.event("progress");
    server.signal(SIGTERM);
    EXPECT_EQ(client.closed(), 1001);
    EXPECT_EQ(server.wait().status, 0);
}

TEST_F(ServerProcessTest, ADiskThatFillsEndsTheRecordingOnly) {
    ServerProcess server = serve({}, 100);  // 50 kB
    Client client(connect(server), server.host());
    client.until(is_frame);
    ASSERT_EQ(client.command({{"id", 1}, {"command", "record_start"}, {"name", "run"}, {"fps", 60}})["type"], "ok");
    const std::string problem = client.event("log")["message"];
    EXPECT_NE(problem.find("cannot be written"), std::string::npos) << problem;
    EXPECT_EQ(problem.find('/'), std::string::npos) << "where it lies is nobody's business: " << problem;
    EXPECT_EQ(client.command({{"id", 2}, {"command", "pause"}})["type"], "ok") << "the simulation goes on";
    const std::string file = (folder_.path() / "data/recordings/run.tfr").string();
    Recording recording(file);
    EXPECT_FALSE(recording.complete());
    EXPECT_GT(recording.frame_count(), 0U) << "what fitted can be read";
    EXPECT_EQ(client.command({{"id", 3}, {"command", "record_stop"}})["type"], "ok");
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait().status, 0);
}

TEST_F(ServerProcessTest, AFrozenClientIsDroppedAndHoldsNobodyUp) {
    ServerProcess server = serve({"--idle-seconds", "3"});
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t frozen = ::fork();
    if (frozen == 0) {  // a process of its own, as SIGSTOP stops whole processes
        try {
            asio::io_context io;
            tcp::socket socket(io);
            socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
            Client client(std::move(socket), server.host());
            client.acknowledge(client.until(is_frame));
            if (::write(pipe[1], "+", 1) != 1) ::_exit(3);
            ::_exit(client.closed() == -1 ? 0 : 1);  // reads until the connection is gone
        } catch (...) {
            ::_exit(2);
        }
    }
    char begun = 0;
    ASSERT_EQ(::read(pipe[0], &begun, 1), 1);
    Client other(connect(server), server.host());
    other.until([](const Message& m) { return viewers_are(m, 2); });
    ::kill(frozen, SIGSTOP);
    for (int i = 0; i < 20; ++i) other.until(is_frame);
    other.until([](const Message& m) { return viewers_are(m, 1); });  // dropped while the other one watches
    ::kill(frozen, SIGCONT);
    int status = -1;
    ::waitpid(frozen, &status, 0);
    EXPECT_EQ(status, 0) << "and finds its connection gone when it wakes up";
    ::close(pipe[0]), ::close(pipe[1]);
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait().status, 0);
}

class FaultTest : public ServerTest {
 protected:
    /// From now on the client's kernel throws away whatever comes for it and confirms nothing, as if its cable were cut.
    static void cut(tcp::socket& socket) {
        sock_filter nothing = BPF_STMT(BPF_RET | BPF_K, 0);
        const sock_fprog program{1, &nothing};
        ASSERT_EQ(::setsockopt(socket.native_handle(), SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program), 0) << std::strerror(errno);
    }
};

TEST_F(FaultTest, HalfOpenConnectionsAreDropped) {
    for (const bool playing : {false, true}) {  // without and with something to send
        start(playing, {.idle_timeout = 2s});
        Client gone(connect(), host()), other(connect(), host());
        gone.until(is_frame);
        other.until([](const Message& m) { return viewers_are(m, 2); });
        cut(gone.stream().next_layer());
        other.until([](const Message& m) { return viewers_are(m, 1); });
        EXPECT_EQ(other.command({{"id", 1}, {"command", "pause"}})["type"], "ok");
        stop();
    }
}

TEST_F(FaultTest, HalfOpenRequestsAreDropped) {
    web_.write("large.txt", std::string(32 << 20, 'x'));  // more than the buffers of both sides, so the answer waits to be taken
    start(false, {.request_timeout = 500ms});
    tcp::socket gone = connect();
    asio::write(gone, asio::buffer("GET /large.txt HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"));
    std::array<char, 12> begin{};
    asio::read(gone, asio::buffer(begin));
    ASSERT_EQ(std::string(begin.data(), begin.size()), "HTTP/1.1 200");
    cut(gone);
    const auto connections = [this] {
        const std::string page = request(http::verb::get, "/metrics").body(), name = "\ntetfront_connections ";
        return std::stoi(page.substr(page.find(name) + name.size()));
    };
    for (int wait = 0; wait < 500 && connections() > 1; ++wait) std::this_thread::sleep_for(20ms);
    EXPECT_EQ(connections(), 1) << "the one that asks";
}

TEST_F(FaultTest, AHundredThousandCommandsASecondHoldNobodyUp) {
    start(true);
    Client other(connect(), host());
    const Message before = other.until(is_frame);
    Client flood(connect(), host());
    constexpr int count = 100'000;
    int answered = 0, refused = 0;
    std::thread reader([&] {
        while (answered < count) {
            const Message m = flood.read();
            if (!m.text || !m.json.contains("id")) continue;
            ++answered;
            refused += m.json["type"] == "error";
        }
    });
    // As one stream of bytes, as fast as the socket takes them: masked frames of less than 126 bytes.
    std::string frames;
    for (int i = 0; i < count; ++i) {
        const std::string text = R"({"id":)" + std::to_string(i) + R"(,"command":"speed","value":1})";
        frames += '\x81';
        frames += static_cast<char>(0x80 | text.size());
        frames += std::string(4, '\0') + text;
    }
    asio::write(flood.stream().next_layer(), asio::buffer(frames));
    EXPECT_EQ(other.command({{"id", 1}, {"command", "speed"}, {"value", 1}})["type"], "ok") << "its own rate counts";
    reader.join();
    EXPECT_EQ(answered, count);
    EXPECT_GT(refused, 0) << "of 100,000 within seconds";
    const Message after = other.until([&](const Message& m) { return is_frame(m) && m.at<double>(16) > before.at<double>(16) + 0.1; });
    EXPECT_GT(after.at<std::uint32_t>(8), before.at<std::uint32_t>(8));
}

TEST_F(FaultTest, AMessageThatComesByteByByteHoldsNobodyUp) {
    start(true);
    Client drip(connect(), host()), other(connect(), host());
    drip.until(is_frame);
    const std::string text = R"({"id":5,"command":"pause"})";
    std::string frame = {'\x81', static_cast<char>(0x80 | text.size()), 0, 0, 0, 0};
    frame += text;
    for (const char byte : frame) {
        asio::write(drip.stream().next_layer(), asio::buffer(&byte, 1));
        other.until(is_frame);
    }
    EXPECT_EQ(drip.answer(5)["type"], "ok");
}

}  // namespace
}  // namespace tetfront
