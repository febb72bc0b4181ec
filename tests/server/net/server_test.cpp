// A small Beast client against a server with a real session: WebSocket, start and stop.

#include "tests/server/net/client.hpp"
#include "tests/server/net/server_fixture.hpp"

#include "server/net/outbox.hpp"

namespace tetfront {
namespace {

TEST_F(ServerTest, SendsHelloModelTopologyFrameStateAlsoWhilePaused) {
    start();
    for (int visit = 0; visit < 2; ++visit) {
        Client client(connect(), host());
        ASSERT_FALSE(client.refused) << client.refused.message();
        EXPECT_EQ(client.response[http::field::sec_websocket_protocol], "tetfront.v1");
        const Message hello = client.until([](const Message& m) { return m.json.value("type", "") != "progress"; });
        EXPECT_EQ(hello.json["type"], "hello");
        EXPECT_EQ(hello.json["scene"]["name"], "beam");
        EXPECT_EQ(hello.json["playing"], false);
        EXPECT_EQ(hello.json["depth"], 1);
        const Message model = client.read(), topology = client.read(), frame = client.read(), settings = client.read(), state = client.read();
        EXPECT_EQ(model.type(), 1);
        EXPECT_EQ(topology.type(), 2);
        EXPECT_EQ(frame.type(), 3);
        EXPECT_EQ(frame.at<std::uint32_t>(4), topology.at<std::uint32_t>(4)) << "same epoch";
        EXPECT_EQ(frame.at<std::uint32_t>(12), model.at<std::uint32_t>(12)) << "same surface";
        ASSERT_TRUE(settings.text && state.text);
        EXPECT_EQ(settings.json["type"], "settings");
        ASSERT_EQ(state.json["type"], "state");
        EXPECT_EQ(state.json["step"], 0);
    }
}

TEST_F(ServerTest, AnswersCommands) {
    start();
    Client client(connect(), host());
    EXPECT_EQ(client.command({{"id", 1}, {"command", "step"}, {"count", 3}}), Json({{"type", "ok"}, {"id", 1}}));
    const Message frame = client.until([](const Message& m) { return m.type() == 3 && m.at<double>(16) > 0; });
    EXPECT_GT(frame.at<std::uint32_t>(8), 0U);
    EXPECT_EQ(client.command({{"id", 2}, {"command", "gravity"}, {"value", {0, 0, 0}}})["type"], "ok");
    client.until([](const Message& m) {
        return m.text && m.json["type"] == "state" && m.json["gravity"] == Json({0.0, 0.0, 0.0});
    });

    Json error = client.command({{"id", 3}, {"command", "gravity"}, {"value", {0, 0, 1e308}}});
    EXPECT_EQ(error["code"], "out_of_range");
    EXPECT_EQ(error["pointer"], "/value/2");
    error = client.command({{"id", 4},
                            {"command", "pull_begin"},
                            {"pull", 0},
                            {"triangle", 99999},
                            {"barycentric", {1, 0, 0}},
                            {"target", {0, 0, 0}}});
    EXPECT_EQ(error["code"], "out_of_range");
    EXPECT_EQ(error["pointer"], "/triangle");
    error = client.command({{"id", 5}, {"command", "fly"}});
    EXPECT_EQ(error["code"], "unknown_command");
}

TEST_F(ServerTest, BadMessagesAreAnsweredAndTheConnectionStays) {
    start();
    Client client(connect(), host());
    client.send("{not json");
    EXPECT_EQ(client.answer(nullptr)["code"], "malformed");
    client.send(std::string(65 * 1024, 'x'));
    EXPECT_EQ(client.answer(nullptr)["code"], "too_large");
    client.send(std::string(64 * 1024, '['));
    EXPECT_EQ(client.answer(nullptr)["code"], "malformed") << "64 KiB are just not too large";
    client.stream().binary(true);
    client.stream().write(asio::buffer(std::string_view("{}")));
    EXPECT_EQ(client.answer(nullptr)["code"], "malformed");
    client.stream().text(true);  // one message in many fragments
    const std::string text = Json({{"id", 1}, {"command", "pause"}}).dump();
    for (std::size_t i = 0; i < text.size(); ++i)
        client.stream().write_some(i + 1 == text.size(), asio::buffer(&text[i], 1));
    EXPECT_EQ(client.answer(1)["type"], "ok");
}

TEST_F(ServerTest, AHugeMessageClosesWith1009AndOthersStay) {
    start();
    Client bad(connect(), host()), good(connect(), host());
    Error error;
    bad.stream().write(asio::buffer(std::string(2 * 1024 * 1024, 'x')), error);
    EXPECT_NE(bad.closed(), 1000);
    EXPECT_EQ(good.command({{"id", 1}, {"command", "pause"}})["type"], "ok");
}

TEST_F(ServerTest, InvalidUtf8ClosesWith1007) {
    start();
    Client client(connect(), host());
    client.send("{\"id\": 1, \"command\": \"\xff\"}");
    EXPECT_EQ(client.closed(), 1007);
}

TEST_F(ServerTest, AnswersEveryCommandOfAFloodOnce) {
    start(true);
    Client client(connect(), host());
    constexpr int count = 5000;
    std::multiset<int> answered;
    std::thread reader([&] {
        while (answered.size() < count) {
            const Message m = client.read();
            if (!m.text || !m.json.contains("id")) continue;
            EXPECT_EQ(m.json.value("code", "too_many"), "too_many") << m.bytes;
            answered.insert(m.json["id"].get<int>());
        }
    });
    for (int i = 0; i < count; ++i) {
        client.send(R"({"id": )" + std::to_string(i) + R"(, "command": "pull_end", "pull": 0})");
    }
    reader.join();
    for (int i = 0; i < count; ++i) EXPECT_EQ(answered.count(i), 1U) << i;
}

TEST_F(ServerTest, RefusesForeignOriginsHostsAndSubprotocols) {
    start();
    const std::string port = std::to_string(server_->port());
    // Beast's client does not show the response of a refusal.
    const auto upgrade_status = [&](const Join& join) {
        http::request<http::empty_body> request(http::verb::get, "/ws", 11);
        request.set(http::field::host, join.host.empty() ? host() : join.host);
        request.set(http::field::connection, "Upgrade");
        request.set(http::field::upgrade, "websocket");
        request.set(http::field::sec_websocket_version, "13");
        request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
        if (!join.origin.empty()) request.set(http::field::origin, join.origin);
        if (!join.protocols.empty()) request.set(http::field::sec_websocket_protocol, join.protocols);
        tcp::socket socket = connect();
        http::write(socket, request);
        beast::flat_buffer buffer;
        http::response<http::string_body> response;
        http::read(socket, buffer, response);
        return response.result();
    };
    const std::vector<std::pair<Join, http::status>> cases = {
        {{.origin = "http://evil.example"}, http::status::forbidden},
        {{.origin = "null"}, http::status::forbidden},
        {{.origin = "https://127.0.0.1:" + port}, http::status::forbidden},
        {{.origin = "http://127.0.0.1:1"}, http::status::forbidden},
        {{.host = "evil.example:" + port}, http::status::forbidden},
        {{.host = "127.0.0.1"}, http::status::forbidden},
        {{.protocols = ""}, http::status::bad_request},
        {{.protocols = "chat"}, http::status::bad_request},
        {{.protocols = "xtetfront.v1"}, http::status::bad_request},
    };
    for (const auto& [join, status] : cases) {
        const Client client(connect(), host(), join);
        EXPECT_EQ(client.refused, websocket::error::upgrade_declined) << join.origin << join.host << join.protocols;
        EXPECT_EQ(upgrade_status(join), status) << join.origin << join.host << join.protocols;
    }
    EXPECT_FALSE(Client(connect(), host(), {.origin = "http://" + host()}).refused);
    EXPECT_FALSE(
        Client(connect(), host(), {.origin = "http://localhost:" + port, .host = "localhost:" + port}).refused);
    EXPECT_FALSE(Client(connect(), host(), {.protocols = "tetfront.v2, tetfront.v1"}).refused);
}

TEST_F(ServerTest, AnotherVersionIsClosedWithAReasonThatBrowsersShow) {
    start();
    Client newer(connect(), host(), {.protocols = "tetfront.v2"});
    ASSERT_FALSE(newer.refused) << newer.refused.message();
    EXPECT_EQ(newer.response[http::field::sec_websocket_protocol], "tetfront.v2") << "or a browser would not open it";
    newer.send(R"({"id": 1, "command": "pause"})");
    EXPECT_EQ(newer.closed(), 1002);
    EXPECT_EQ(newer.stream().reason().reason, "this server speaks tetfront.v1");
    Client other(connect(), host());
    EXPECT_EQ(other.command({{"id", 1}, {"command", "pause"}})["type"], "ok");
}

TEST_F(ServerTest, PingsAndThenDropsASilentViewer) {
    start(false, {.idle_timeout = 200ms});
    Client client(connect(), host());
    client.until([](const Message& m) { return m.type() == 3; });
    // Not reading, it cannot answer the ping; the server gives up and the socket ends.
    std::this_thread::sleep_for(1s);
    EXPECT_EQ(client.closed(), -1);
    Client other(connect(), host());
    const Json state = other.until([](const Message& m) { return m.text && m.json["type"] == "state"; }).json;
    EXPECT_EQ(state["viewers"], 1);
}

TEST_F(ServerTest, ASlowViewerGetsTheLatestFrame) {
    Scene scene = box_scene();
    scene.mesh = BoxMeshSpec{{0, 0, 0}, {4, 1, 1}, {24, 6, 6}};  // frames of 15 kB
    scene.levels = 0;
    scene.front.order = 1;
    scene.gravity.setZero();  // at rest a step costs little
    scene.time_step = 0.1;
    start(true, {.idle_timeout = 300s}, scene);  // the slow one is not taken for dead, however slow all of this is
    tcp::socket socket = connect();
    socket.set_option(asio::socket_base::receive_buffer_size(65536));
    const std::string address = host();
    Client slow(std::move(socket), address), fast(connect(), address);
    const auto is_frame = [](const Message& m) { return m.type() == 3; };
    const auto first = slow.until(is_frame).at<std::uint32_t>(8);
    fast.command({{"id", 1}, {"command", "speed"}, {"value", 10}});
    Message now = fast.until(is_frame);
    while (now.at<double>(16) < 20) now = fast.until(is_frame);  // 200 steps, 4 MB of frames
    // The slow one has the frames that were in the sockets' buffers, and then the present: what lies between is
    // skipped.
    int read = 0;
    Message seen = now;
    do {
        seen = slow.until(is_frame);
        ++read;
    } while (seen.at<double>(16) < now.at<double>(16));
    EXPECT_LT(read, static_cast<int>(seen.at<std::uint32_t>(8) - first));
    EXPECT_EQ(slow.command({{"id", 2}, {"command", "pause"}})["type"], "ok");
}

TEST_F(ServerTest, AViewerThatNeverReadsItsAnswersIsClosed) {
    start();
    tcp::socket socket = connect();
    socket.set_option(asio::socket_base::receive_buffer_size(4096));
    Client client(std::move(socket), host());
    client.until([](const Message& m) { return m.type() == 3; });
    Error error;
    for (int i = 0; i < 100'000 && !error; ++i) client.stream().write(asio::buffer(std::string_view("?")), error);
    Client other(connect(), host());
    other.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["viewers"] == 1; });
}

TEST_F(ServerTest, PullsEndWithTheirConnection) {
    start();
    Client watcher(connect(), host());
    {
        Client puller(connect(), host());
        EXPECT_EQ(puller.command({{"id", 1},
                                  {"command", "pull_begin"},
                                  {"pull", 0},
                                  {"triangle", 0},
                                  {"barycentric", {1, 0, 0}},
                                  {"target", {0, 0, 2}}})["type"],
                  "ok");
        const Message frame =
            watcher.until([](const Message& m) { return m.type() == 3 && m.at<std::uint32_t>(28) == 1; });
        EXPECT_EQ(frame.bytes.size() % 4, 0U);
    }
    watcher.until([](const Message& m) { return m.type() == 3 && m.at<std::uint32_t>(28) == 0; });
}

TEST_F(ServerTest, CountsViewers) {
    start();
    const auto viewers = [](Client& client, int n) {
        client.until([n](const Message& m) { return m.text && m.json["type"] == "state" && m.json["viewers"] == n; });
    };
    Client first(connect(), host());
    viewers(first, 1);
    {
        Client second(connect(), host());
        viewers(first, 2);
        viewers(second, 2);
    }
    viewers(first, 1);
}

TEST_F(ServerTest, StopClosesWith1001) {
    start(true);
    Client client(connect(), host());
    tcp::socket idle = connect();
    client.until([](const Message& m) { return m.type() == 3; });
    std::thread stopper([&] { stop(); });
    EXPECT_EQ(client.closed(), 1001);
    stopper.join();
    EXPECT_FALSE(failure_);
}

TEST_F(ServerTest, StopDoesNotWaitForAViewerThatDoesNotReact) {
    start(true);
    Client client(connect(), host());
    client.until([](const Message& m) { return m.type() == 3; });
    stop();
    EXPECT_FALSE(failure_);
}

TEST_F(ServerTest, AFailedBuildEndsRunWithItsError) {
    Scene scene = box_scene();
    scene.mesh = SurfaceMeshSpec{{"/nowhere/model.obj"}, 1, 100};
    start(true, {}, scene);
    join();
    ASSERT_TRUE(failure_);
    EXPECT_THROW(std::rethrow_exception(failure_), InputError);
}

TEST_F(ServerTest, ATakenPortAndABadAddressAreErrors) {
    start();
    Session other(box_scene(), false);
    EXPECT_THROW(Server({.port = server_->port()}, load_web_files(web_.path()), other), PortTaken);
    EXPECT_THROW(Server({.host = "not an address", .port = 0}, load_web_files(web_.path()), other), InputError);
    EXPECT_THROW(Server({.host = "192.0.2.1", .port = 0}, load_web_files(web_.path()), other), InputError);
}

}  // namespace
}  // namespace tetfront
