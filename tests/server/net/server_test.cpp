// A small Beast client against a server with a real session. The only test file that includes Beast.

#include "server/net/server.hpp"

#include "engine/base/error.hpp"
#include "server/net/outbox.hpp"
#include "tests/support/box_scene.hpp"
#include "tests/support/temporary_folder.hpp"

#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using Json = nlohmann::json;
using namespace std::chrono_literals;

class ServerTest : public testing::Test {
 protected:
    ServerTest() {
        web_.write("index.html", "<!doctype html><title>test</title>");
        web_.write("assets/app.js", "console.log(1)");
    }
    ~ServerTest() override { stop(); }

    void start(bool playing = false, Server::Options options = {}, Scene scene = box_scene()) {
        options.port = 0;
        session_ = std::make_unique<Session>(std::move(scene), playing);
        server_ = std::make_unique<Server>(options, load_web_files(web_.path()), *session_);
        thread_ = std::thread([this] {
            try {
                server_->run();
            } catch (...) {
                failure_ = std::current_exception();
            }
        });
    }
    void stop() {
        if (!thread_.joinable()) return;
        server_->stop();
        thread_.join();
    }
    /// Waits until run() has returned by itself.
    void join() { thread_.join(); }

    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(server_->port()); }

    tcp::socket connect() {
        tcp::socket socket(io_);
        socket.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
        return socket;
    }

    /// Sends bytes and returns everything up to the end of the connection.
    std::string exchange(std::string_view bytes) {
        tcp::socket socket = connect();
        asio::write(socket, asio::buffer(bytes));
        std::string answer;
        Error error;
        asio::read(socket, asio::dynamic_buffer(answer), error);
        return answer;
    }
    http::response<http::string_body> request(http::verb verb, const std::string& target,
                                              const std::map<std::string, std::string>& headers = {}) {
        tcp::socket socket = connect();
        http::request<http::empty_body> message(verb, target, 11);
        message.set(http::field::host, host());
        for (const auto& [name, value] : headers) message.set(name, value);
        http::write(socket, message);
        http::response_parser<http::string_body> parser;
        parser.skip(verb == http::verb::head);
        beast::flat_buffer buffer;
        http::read(socket, buffer, parser);
        return parser.release();
    }

    TemporaryFolder web_;
    asio::io_context io_;
    std::unique_ptr<Session> session_;
    std::unique_ptr<Server> server_;
    std::exception_ptr failure_;

 private:
    std::thread thread_;
};

struct Message {
    bool text;
    std::string bytes;
    Json json;  // of a text
    [[nodiscard]] int type() const { return text ? 0 : bytes[0]; }
    template <class T>
    [[nodiscard]] T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, bytes.data() + offset, sizeof value);
        return value;
    }
};

struct Join {
    std::string origin = {};
    std::string host = {};  // empty: the right one
    std::string protocols = "tetfront.v1";
};

class Client {
 public:
    Client(tcp::socket socket, std::string host, const Join& join = {}) : stream_(std::move(socket)) {
        stream_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
            if (!join.protocols.empty()) request.set(http::field::sec_websocket_protocol, join.protocols);
            if (!join.origin.empty()) request.set(http::field::origin, join.origin);
        }));
        stream_.handshake(response, join.host.empty() ? host : join.host, "/ws", refused);
    }

    Message read() {
        beast::flat_buffer buffer;
        stream_.read(buffer);
        Message message{stream_.got_text(), beast::buffers_to_string(buffer.data()), {}};
        if (message.text) message.json = Json::parse(message.bytes);
        return message;
    }
    /// Reads on until a message is as wanted.
    Message until(const std::function<bool(const Message&)>& wanted) {
        for (;;)
            if (Message message = read(); wanted(message)) return message;
    }
    Json answer(const Json& id) {
        return until([&](const Message& m) { return m.text && m.json.contains("id") && m.json["id"] == id; }).json;
    }
    void send(std::string_view text) { stream_.text(true), stream_.write(asio::buffer(text)); }
    Json command(Json message) {
        send(message.dump());
        return answer(message["id"]);
    }
    /// Reads until the server has closed; the close code.
    int closed() {
        Error error;
        for (beast::flat_buffer buffer; !error; buffer.clear()) stream_.read(buffer, error);
        return error == websocket::error::closed ? stream_.reason().code : -1;
    }

    websocket::response_type response;
    Error refused;
    websocket::stream<tcp::socket>& stream() { return stream_; }

 private:
    websocket::stream<tcp::socket> stream_;
};

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
        const Message model = client.read(), topology = client.read(), frame = client.read(), state = client.read();
        EXPECT_EQ(model.type(), 1);
        EXPECT_EQ(topology.type(), 2);
        EXPECT_EQ(frame.type(), 3);
        EXPECT_EQ(frame.at<std::uint32_t>(4), topology.at<std::uint32_t>(4)) << "same epoch";
        EXPECT_EQ(frame.at<std::uint32_t>(12), model.at<std::uint32_t>(12)) << "same surface";
        ASSERT_TRUE(state.text);
        EXPECT_EQ(state.json["type"], "state");
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
        {{.protocols = "tetfront.v2"}, http::status::bad_request},
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

TEST_F(ServerTest, ServesTheBuiltFilesOnly) {
    start();
    auto page = request(http::verb::get, "/");
    EXPECT_EQ(page.result(), http::status::ok);
    EXPECT_EQ(page.body(), "<!doctype html><title>test</title>");
    EXPECT_EQ(page[http::field::content_type], "text/html; charset=utf-8");
    EXPECT_EQ(page[http::field::cache_control], "no-store");
    EXPECT_EQ(page["X-Content-Type-Options"], "nosniff");
    const std::string policy(page["Content-Security-Policy"]);
    EXPECT_NE(policy.find("default-src 'none'"), std::string::npos);
    EXPECT_EQ(policy.find("unsafe"), std::string::npos);

    const auto script = request(http::verb::get, "/assets/app.js?v=1");
    EXPECT_EQ(script.result(), http::status::ok);
    const std::string etag(script[http::field::etag]);
    EXPECT_EQ(request(http::verb::get, "/assets/app.js", {{"If-None-Match", etag}}).result(),
              http::status::not_modified);
    const auto head = request(http::verb::head, "/assets/app.js");
    EXPECT_EQ(head[http::field::content_length], "14");
    EXPECT_TRUE(head.body().empty());

    for (const char* target :
         {"/nothing", "/../server.cpp", "/assets/../index.html", "/%2e%2e/etc/passwd", "//etc/passwd", "/assets"})
        EXPECT_EQ(request(http::verb::get, target).result(), http::status::not_found) << target;
    for (const auto verb :
         {http::verb::post, http::verb::put, http::verb::delete_, http::verb::options, http::verb::trace}) {
        const auto refused = request(verb, "/");
        EXPECT_EQ(refused.result(), http::status::method_not_allowed) << verb;
        EXPECT_EQ(refused[http::field::allow], "GET, HEAD");
    }
    EXPECT_EQ(request(http::verb::get, "/ws").result(), http::status::upgrade_required);
    EXPECT_EQ(request(http::verb::get, "/", {{"Host", "evil.example"}}).result(), http::status::forbidden);
}

TEST_F(ServerTest, DrawsSnapshots) {
    start();
    http::response<http::string_body> answer;
    const auto ask = [&](const std::string& query, http::verb verb = http::verb::get) {
        for (int i = 0; i < 600; ++i) {  // until the model is built, and not more often than allowed
            answer = request(verb, "/snapshot.png" + query);
            if (answer.result_int() != 503 && answer.result_int() != 429) return answer.result_int();
            EXPECT_EQ(answer[http::field::retry_after], "1");
            std::this_thread::sleep_for(50ms);
        }
        return 0U;
    };
    ASSERT_EQ(ask("?w=160&h=90"), 200U) << answer.body();
    EXPECT_EQ(answer[http::field::content_type], "image/png");
    const std::string fitted = answer.body();
    EXPECT_EQ(fitted.substr(1, 3), "PNG");
    EXPECT_EQ(static_cast<unsigned char>(fitted[19]), 160) << "width";
    EXPECT_EQ(static_cast<unsigned char>(fitted[23]), 90) << "height";
    ASSERT_EQ(ask("?w=160&h=90&camera=9,-9,4,2,0,0&colouring=stress"), 200U) << answer.body();
    EXPECT_NE(answer.body(), fitted);
    ASSERT_EQ(ask("?w=160&h=90&view=%7B%22wireframe%22%3A+true%7D"), 200U) << answer.body();
    EXPECT_NE(answer.body(), fitted);
    EXPECT_EQ(ask("?w=160&h=90", http::verb::head), 200U);
    EXPECT_TRUE(answer.body().empty());
    for (const char* bad : {"?w=8", "?w=9999", "?w=", "?w=nan", "?h=1e3", "?x=1", "?w=100&w=100", "?camera=1,2,3", "?camera=1,2,3,4,5,6,7",
                            "?camera=1,2,3,1,2,3", "?colouring=rainbow", "?view=%7B", "?view=%zz", "?view=%2", "?colouring=%22%7D"}) {
        EXPECT_EQ(ask(bad), 400U) << bad;
        EXPECT_EQ(answer.body().find('\n'), answer.body().size() - 1) << bad;
    }
    EXPECT_EQ(request(http::verb::get, "/snapshot.png", {{"Host", "evil.example"}}).result_int(), 403);
    EXPECT_EQ(request(http::verb::get, "/snapshot.png", {{"Origin", "http://evil.example"}}).result_int(), 403);
    EXPECT_EQ(request(http::verb::post, "/snapshot.png").result_int(), 405);
}

TEST_F(ServerTest, SnapshotsComeOneAtATime) {
    start();
    while (request(http::verb::get, "/snapshot.png?w=64&h=64").result_int() == 503) std::this_thread::sleep_for(50ms);
    std::this_thread::sleep_for(200ms);
    std::map<unsigned, int> counts;
    std::mutex mutex;
    {
        std::vector<std::jthread> clients;
        for (int i = 0; i < 8; ++i)
            clients.emplace_back([&] {
                asio::io_context io;
                tcp::socket socket(io);
                socket.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
                http::request<http::empty_body> message(http::verb::get, "/snapshot.png?w=320&h=180", 11);
                message.set(http::field::host, host());
                http::write(socket, message);
                beast::flat_buffer buffer;
                http::response<http::string_body> response;
                http::read(socket, buffer, response);
                const std::lock_guard lock(mutex);
                ++counts[response.result_int()];
            });
    }
    EXPECT_GE(counts[200], 1);
    EXPECT_GE(counts[429], 1) << "eight at once are too many";
    EXPECT_EQ(counts[200] + counts[429], 8);
}

TEST_F(ServerTest, StopsWhileASnapshotIsDrawn) {
    start();
    while (request(http::verb::get, "/snapshot.png?w=64&h=64").result_int() == 503) std::this_thread::sleep_for(50ms);
    std::this_thread::sleep_for(200ms);
    tcp::socket socket = connect();
    asio::write(socket, asio::buffer("GET /snapshot.png?w=2048&h=2048 HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"));
    std::this_thread::sleep_for(50ms);
    stop();  // returns, and nothing is used after it is gone
}

TEST_F(ServerTest, AnswersPipelinedRequestsInOrder) {
    start();
    const auto get = [&](const std::string& target, bool last) {
        return "GET " + target + " HTTP/1.1\r\nHost: " + host() + (last ? "\r\nConnection: close" : "") + "\r\n\r\n";
    };
    std::string all;
    for (int i = 0; i < 40; ++i) all += get(i % 2 ? "/assets/app.js" : "/none", false);
    const std::string answer = exchange(all + get("/", true));
    std::size_t at = 0;
    for (int i = 0; i < 40; ++i) {
        const std::string status = i % 2 ? "HTTP/1.1 200" : "HTTP/1.1 404";
        at = answer.find("HTTP/1.1 ", at);
        ASSERT_NE(at, std::string::npos) << i;
        EXPECT_EQ(answer.substr(at, status.size()), status) << i;
        ++at;
    }
    EXPECT_TRUE(answer.ends_with("<!doctype html><title>test</title>"));
}

TEST_F(ServerTest, SurvivesBrokenRequests) {
    start();
    const auto status = [](const std::string& answer) {
        return answer.substr(0, std::min<std::size_t>(answer.size(), 12));
    };
    EXPECT_EQ(status(exchange("\x16\x03\x01 this is TLS\r\n\r\n")), "HTTP/1.1 400");
    EXPECT_EQ(status(exchange("GET / HTTP/1.1\r\nHost: " + host() + "\r\nX: " + std::string(10'000, 'x') + "\r\n\r\n")),
              "HTTP/1.1 431");
    EXPECT_EQ(status(exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n")), "HTTP/1.1 403") << "no Host";
    EXPECT_EQ(
        status(exchange("GET / HTTP/1.1\r\nHost: " + host() + "\r\nHost: evil.example\r\nConnection: close\r\n\r\n")),
        "HTTP/1.1 403");
    EXPECT_EQ(status(exchange("POST / HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: 100000\r\n\r\n" +
                              std::string(100'000, 'b'))),
              "HTTP/1.1 405");
    EXPECT_EQ(request(http::verb::get, "/").result(), http::status::ok);
}

TEST_F(ServerTest, DropsRequestsThatNeverEnd) {
    start(false, {.request_timeout = 100ms});
    EXPECT_EQ(exchange("GET / HTTP/1.1\r\nHost: "), "");
    EXPECT_EQ(exchange(""), "");
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
    start(true, {}, scene);
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
    scene.mesh = SurfaceMeshSpec{"/nowhere/model.obj", 1, 100};
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
