// Plain HTTP: files, snapshots, broken requests.

#include "tests/server/net/server_fixture.hpp"

namespace tetfront {
namespace {

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

}  // namespace
}  // namespace tetfront
