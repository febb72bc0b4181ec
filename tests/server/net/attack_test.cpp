// What an attacker or a broken client tries, against a running server: each must cost it its own connection at most.

#include "tests/server/net/client.hpp"

#include <filesystem>

namespace tetfront {
namespace {

const std::string secret = "0123456789abcdef-secret";

class AttackTest : public ServerTest {
 protected:
    /// The server still serves.
    void expect_well() {
        Client client(connect(), host(), {.authorization = "Bearer " + secret});
        ASSERT_FALSE(client.refused) << client.refused.message();
        EXPECT_EQ(client.command({{"id", 1}, {"command", "pause"}})["type"], "ok");
    }
    [[nodiscard]] std::string upgrade() const {
        return "GET /ws HTTP/1.1\r\nHost: " + host() +
               "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: tetfront.v1\r\n\r\n";
    }
    static std::ptrdiff_t descriptors() {
        return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator{});
    }
    std::string get(const std::string& target, const std::string& more = {}) {
        return exchange("GET " + target + " HTTP/1.1\r\nHost: " + host() + "\r\nConnection: close\r\n" + more + "\r\n");
    }
};

TEST_F(AttackTest, WithoutTheTokenNothingButThePageIsServed) {
    start(false, {.token = secret});
    EXPECT_EQ(request(http::verb::get, "/").result_int(), 200);
    EXPECT_EQ(request(http::verb::get, "/healthz").result_int(), 200);
    const std::vector<std::map<std::string, std::string>> strangers = {
        {}, {{"Authorization", "Bearer wrong"}}, {{"Cookie", "tetfront_token=wrong"}}};
    for (const char* target : {"/session", "/metrics", "/snapshot.png", "/recordings/x.tfr"})
        for (const auto& headers : strangers) {
            const auto answer = request(http::verb::get, target, headers);
            EXPECT_EQ(answer.result_int(), 401) << target;
            EXPECT_EQ(answer[http::field::www_authenticate], "Bearer");
            EXPECT_EQ(answer[http::field::set_cookie], "");
        }
    EXPECT_EQ(request(http::verb::get, "/metrics", {{"Authorization", "Bearer " + secret}}).result_int(), 200);
    EXPECT_EQ(request(http::verb::get, "/metrics?token=" + secret).result_int(), 401) << "never part of an address";
    const auto session = request(http::verb::get, "/session", {{"Authorization", "Bearer " + secret}});
    EXPECT_EQ(session.result_int(), 204);
    const std::string cookie(session[http::field::set_cookie].substr(0, session[http::field::set_cookie].find(';')));
    EXPECT_EQ(request(http::verb::get, "/metrics", {{"Cookie", cookie}}).result_int(), 200);
    Client by_cookie(connect(), host(), {.cookie = cookie});
    EXPECT_EQ(by_cookie.event("hello")["protocol"], 1);
}

TEST_F(AttackTest, TheFirstMessageMayBeTheToken) {
    start(false, {.token = secret});
    Client right(connect(), host());
    EXPECT_EQ(right.command({{"id", 5}, {"command", "token"}, {"value", secret}})["type"], "ok");
    EXPECT_EQ(right.command({{"id", 6}, {"command", "step"}})["type"], "ok");
    for (const std::string& first : {Json({{"id", 1}, {"command", "token"}, {"value", "wrong"}}).dump(), Json({{"id", 1}, {"command", "play"}}).dump(),
                                     std::string("?"), std::string(R"({"command": "ack", "frame": 1})"), std::string(70'000, 'x')}) {
        Client client(connect(), host());
        client.send(first);
        const Message answer = [&] {
            Message m{};
            beast::flat_buffer buffer;
            Error error;
            client.stream().read(buffer, error);
            m.bytes = beast::buffers_to_string(buffer.data());
            return m;
        }();
        EXPECT_EQ(answer.bytes, "") << "nothing is said before the token";
        EXPECT_EQ(client.stream().reason().code, 4001);
    }
    expect_well();
}

TEST_F(AttackTest, AClientThatNeverSaysTheTokenIsClosed) {
    start(false, {.token = secret, .request_timeout = 200ms});
    Client client(connect(), host());
    EXPECT_EQ(client.closed(), 4001);
}

TEST_F(AttackTest, BeyondTheLoopbackATokenIsNeeded) {
    Session session(box_scene(), false);
    EXPECT_THROW(Server({.host = "0.0.0.0", .port = 0}, load_web_files(web_.path()), session), InputError);
    EXPECT_NO_THROW(Server({.host = "0.0.0.0", .port = 0, .token = secret}, load_web_files(web_.path()), session));
}

TEST_F(AttackTest, NoPathLeavesTheServedFiles) {
    TemporaryFolder data;
    data.write("recordings/run.tfr", "recorded");
    data.write("secret.tfr", "secret");
    start(false, {}, box_scene(), {.library = Library({}, data.path())});
    EXPECT_NE(get("/recordings/run.tfr").find("recorded"), std::string::npos);
    for (const char* target :
         {"/../etc/passwd", "/assets/../../etc/passwd", "//etc/passwd", "/%2e%2e/etc/passwd", "/..%2fetc%2fpasswd", "/%252e%252e/etc/passwd",
          "/..\\etc\\passwd", "/%c0%ae%c0%ae/etc/passwd", "/assets/%00.js", "/recordings/../secret.tfr", "/recordings/%2e%2e%2fsecret.tfr",
          "/recordings/..%5csecret.tfr", "/recordings//run.tfr", "/recordings/./run.tfr", "/recordings/run.tfr/", "/recordings/", "/recordings/..",
          "/recordings/%72un.tfr", "file:///etc/passwd", "/recordings/run.tfr%00", "/assets"}) {
        const std::string answer = get(target);
        EXPECT_NE(answer.find(" 404 "), std::string::npos) << target << '\n' << answer.substr(0, 200);
        EXPECT_EQ(answer.find("root:"), std::string::npos) << target;
        EXPECT_EQ(answer.find("secret"), std::string::npos) << target;
    }
    expect_well();
}

TEST_F(AttackTest, ALinkIntoTheFolderOfRecordingsIsNotRejectedButAFolderIs) {
    TemporaryFolder data;
    std::filesystem::create_directories(data.path() / "recordings" / "folder.tfr");
    start(false, {}, box_scene(), {.library = Library({}, data.path())});
    EXPECT_NE(get("/recordings/folder.tfr").find(" 404 "), std::string::npos);
}

TEST_F(AttackTest, EveryNumberOfEveryCommandMayBeNonsense) {
    start();
    Client client(connect(), host());
    const std::vector<Json> commands = {
        {{"command", "step"}, {"count", 1}}, {{"command", "speed"}, {"value", 1}},
        {{"command", "pull_begin"}, {"pull", 0}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"target", {0, 0, 0}}},
        {{"command", "pull_move"}, {"pull", 0}, {"target", {0, 0, 0}}}, {{"command", "pull_end"}, {"pull", 0}},
        {{"command", "gravity"}, {"value", {0, 0, 0}}}, {{"command", "tolerance"}, {"value", 0.1}},
        {{"command", "budget"}, {"tets", 100}, {"milliseconds", 1}}, {{"command", "seek"}, {"time", 1}},
        {{"command", "force_add"}, {"force", 0}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"value", {0, 0, 0}}},
        {{"command", "force_move"}, {"force", 0}, {"value", {0, 0, 0}}}, {{"command", "force_remove"}, {"force", 0}},
        {{"command", "force_move"}, {"force", 0}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"value", {0, 0, 0}}},
        {{"command", "pin"}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"radius", 0}},
        {{"command", "unpin"}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"radius", 0}},
        {{"command", "stiffness_scale"}, {"value", 1}},
        {{"command", "stiffness_scale"}, {"value", 1}, {"triangle", 0}, {"barycentric", {1, 0, 0}}, {"radius", 0}}, {{"command", "damping"}, {"mass", 0}, {"stiffness", 0}},
        {{"command", "order"}, {"value", 2}}, {{"command", "levels"}, {"min", 0}, {"max", 1}}, {{"command", "record_start"}, {"fps", 30}}};
    const auto refused = [&](std::string text, const char* nonsense) {
        const std::size_t at = text.find("\"HERE\"");
        text.replace(at, 6, nonsense);
        client.send(text);
        // Where the whole text is no JSON the id cannot be read.
        const Json answer = client.until([](const Message& m) { return m.text && m.json.contains("id"); }).json;
        EXPECT_EQ(answer["type"], "error") << text;
    };
    for (const char* nonsense : {"NaN", "Infinity", "-Infinity", "1e308", "-1e308", "1e400", "\"1\"", "null", "[]", "18446744073709551616"}) {
        refused(R"({"id": "HERE", "command": "pause"})", nonsense);
        refused(R"({"command": "ack", "frame": "HERE"})", nonsense);
        for (const Json& command : commands) {
            for (const auto& [key, value] : command.items()) {
                if (key == "command") continue;
                Json bad = command;
                bad["id"] = 1;
                const std::size_t slots = value.is_array() ? 3 : 1;
                for (std::size_t i = 0; i < slots; ++i) {
                    Json one = bad;
                    (value.is_array() ? one[key][i] : one[key]) = "HERE";
                    refused(one.dump(), nonsense);
                }
            }
        }
    }
    expect_well();
    const Json state = client.command({{"id", 2}, {"command", "step"}, {"count", 3}});
    EXPECT_EQ(state["type"], "ok");
    EXPECT_TRUE(client.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 3; }).json["estimate"].is_number());
}

TEST_F(AttackTest, PipelinedRequestsAreAnsweredOneAfterAnother) {
    start();
    std::string requests;
    for (int i = 0; i < 50; ++i) requests += "GET /assets/app.js HTTP/1.1\r\nHost: " + host() + "\r\n\r\n";
    requests += "GET /nothing HTTP/1.1\r\nHost: " + host() + "\r\nConnection: close\r\n\r\n";
    const std::string answers = exchange(requests);
    std::size_t count = 0;
    for (std::size_t at = answers.find("HTTP/1.1 200 OK"); at != std::string::npos; at = answers.find("HTTP/1.1 200 OK", at + 1)) ++count;
    EXPECT_EQ(count, 50U);
    EXPECT_NE(answers.find(" 404 "), std::string::npos);
}

TEST_F(AttackTest, SlowLorisIsDroppedAndBlocksNobody) {
    start(false, {.request_timeout = 400ms});
    std::vector<tcp::socket> loris;
    for (int i = 0; i < 20; ++i) {
        loris.push_back(connect());
        asio::write(loris.back(), asio::buffer(std::string_view("GET / HTTP/1.1\r\nHos")));
    }
    expect_well();
    // A byte now and then does not prolong the deadline of the whole request.
    Error error;
    for (int i = 0; i < 40 && !error; ++i) {
        std::this_thread::sleep_for(100ms);
        asio::write(loris[0], asio::buffer(std::string_view("t")), error);
    }
    EXPECT_TRUE(error) << "still open after ten times the limit";
}

TEST_F(AttackTest, ConnectionsOfOneAddressAreBounded) {
    start(false, {.limits = {.connections_per_address = 3}});
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 3; ++i) {
        clients.push_back(std::make_unique<Client>(connect(), host()));
        clients.back()->event("hello");
    }
    Client fourth(connect(), host());
    EXPECT_EQ(fourth.closed(), 1013);
    EXPECT_EQ(request(http::verb::get, "/").result_int(), 429);
    clients.clear();
    for (int i = 0; i < 200 && request(http::verb::get, "/").result_int() != 200; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(request(http::verb::get, "/").result_int(), 200);
}

TEST_F(AttackTest, OneAddressDoesNotHoldAllConnections) {
    start(false, {.limits = {.connections = 20, .connections_per_address = 4}});
    std::vector<tcp::socket> idle;
    for (int i = 0; i < 40; ++i) idle.push_back(connect());
    tcp::socket other(io_, tcp::endpoint(asio::ip::make_address("127.0.0.2"), 0));
    other.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
    asio::write(other, asio::buffer("GET /healthz HTTP/1.1\r\nHost: " + host() + "\r\nConnection: close\r\n\r\n"));
    std::string answer;
    Error error;
    asio::read(other, asio::dynamic_buffer(answer), error);
    EXPECT_NE(answer.find(" 200 "), std::string::npos) << answer;
}

TEST_F(AttackTest, TheLimitOfClientsHoldsForThoseWhoSayTheTokenLater) {
    start(false, {.limits = {.clients = 1}, .token = secret});
    Client first(connect(), host()), second(connect(), host());
    EXPECT_EQ(first.command({{"id", 1}, {"command", "token"}, {"value", secret}})["type"], "ok");
    second.send(Json({{"id", 1}, {"command", "token"}, {"value", secret}}).dump());
    EXPECT_EQ(second.closed(), 1013);
    EXPECT_EQ(first.command({{"id", 2}, {"command", "step"}})["type"], "ok");
}

TEST_F(AttackTest, WhoClosesHisSideAndDoesNotReadIsForgotten) {
    start();
    expect_well();
    const auto before = descriptors();
    std::vector<tcp::socket> deaf;
    for (int i = 0; i < 3; ++i) {
        tcp::socket& socket = deaf.emplace_back(io_);
        socket.open(tcp::v4());
        socket.set_option(asio::socket_base::receive_buffer_size(4096));
        socket.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
        asio::write(socket, asio::buffer(upgrade()));
        std::array<char, 12> begin{};
        asio::read(socket, asio::buffer(begin));
        EXPECT_EQ(std::string_view(begin.data(), begin.size()), "HTTP/1.1 101");
        std::string bytes;
        for (int k = 0; k < 9000; ++k) bytes += std::string("\x81\x81\0\0\0\0?", 7);  // answers that do not fit into any buffer
        asio::write(socket, asio::buffer(bytes));
        socket.shutdown(tcp::socket::shutdown_send);
    }
    const auto ours = static_cast<std::ptrdiff_t>(deaf.size());
    for (int i = 0; i < 6000 && descriptors() > before + ours; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_LE(descriptors(), before + ours) << "sockets of clients that are gone";
    stop();  // returns, although they still hold their ends
}

TEST_F(AttackTest, ClientsAreBounded) {
    start(false, {.limits = {.clients = 1}});
    Client first(connect(), host());
    first.event("hello");
    Client second(connect(), host());
    EXPECT_EQ(second.closed(), 1013);
    EXPECT_EQ(first.command({{"id", 1}, {"command", "step"}})["type"], "ok");
}

TEST_F(AttackTest, CompressionIsNotNegotiated) {
    start();
    websocket::stream<tcp::socket> stream(connect());
    websocket::permessage_deflate deflate;
    deflate.client_enable = true;
    stream.set_option(deflate);
    stream.set_option(websocket::stream_base::decorator(
        [](websocket::request_type& request) { request.set(http::field::sec_websocket_protocol, "tetfront.v1"); }));
    websocket::response_type response;
    stream.handshake(response, host(), "/ws");
    EXPECT_EQ(response[http::field::sec_websocket_extensions], "") << "so there are no compression bombs";
}

TEST_F(AttackTest, AMessageInAMillionFragmentsOfNothing) {
    start();
    Client client(connect(), host());
    client.stream().text(true);
    Error error;
    for (int i = 0; i < 5000 && !error; ++i) client.stream().write_some(false, asio::buffer("", 0), error);
    const std::string text = R"({"id": 9, "command": "pause"})";
    client.stream().write_some(true, asio::buffer(text), error);
    EXPECT_EQ(client.answer(9)["type"], "ok");
}

TEST_F(AttackTest, ConnectingAndLeavingLeavesNothingBehind) {
    start(true);
    expect_well();
    const auto before = descriptors();
    for (int i = 0; i < 300; ++i) {
        tcp::socket socket = connect();
        if (i % 3 == 0) continue;
        const std::string head = upgrade();
        asio::write(socket, asio::buffer(i % 3 == 1 ? head.substr(0, head.size() / 2) : head));
        if (i % 3 == 2) {
            std::array<char, 12> begin{};
            asio::read(socket, asio::buffer(begin));
            asio::write(socket, asio::buffer(std::string("\x81\xfe\x10\x00half", 8)));  // of a message of 4096 bytes
        }
    }
    Client last(connect(), host());
    last.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["viewers"] == 1; });
    for (int i = 0; i < 300 && descriptors() > before + 4; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_LE(descriptors(), before + 4);
}

TEST_F(AttackTest, HealthAndMetricsTellHowItGoes) {
    start(true);
    Client client(connect(), host());
    client.until([](const Message& m) { return m.type() == 3; });
    client.command({{"id", 1}, {"command", "fly"}});
    EXPECT_EQ(request(http::verb::get, "/healthz").body(), "ok\n");
    EXPECT_EQ(request(http::verb::get, "/readyz").body(), "ok\n");
    const auto page = request(http::verb::get, "/metrics");
    EXPECT_EQ(page.result_int(), 200);
    EXPECT_NE(std::string(page[http::field::content_type]).find("version=0.0.4"), std::string::npos);
    for (const char* line : {"tetfront_viewers 1\n", "# TYPE tetfront_steps_total counter\n", "tetfront_errors_total{code=\"unknown_command\"} 1\n",
                             "tetfront_front_tets{level=\"0\"}", "tetfront_step_milliseconds{phase=\"solve\"}", "tetfront_frames_sent_total "})
        EXPECT_NE(page.body().find(line), std::string::npos) << line << '\n' << page.body();
    EXPECT_EQ(request(http::verb::post, "/metrics").result_int(), 405);
}

TEST_F(AttackTest, AStalledSimulationIsUnhealthy) {
    start(true, {.limits = {.stall = 1ms}}, [] {
        Scene scene = box_scene();
        scene.levels = 4;
        scene.front.min_level = 3;
        return scene;
    }());
    bool stalled = false;
    for (int i = 0; i < 2000 && !stalled; ++i) {
        const auto answer = request(http::verb::get, "/healthz");
        stalled = answer.result_int() == 503;
        if (stalled) {
            EXPECT_NE(answer.body().find("simulation thread"), std::string::npos);
        }
    }
    EXPECT_TRUE(stalled) << "a step of this front takes more than a millisecond";
}

}  // namespace
}  // namespace tetfront
