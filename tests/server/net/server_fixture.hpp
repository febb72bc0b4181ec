#pragma once
// A running server with a real session, and plain HTTP requests to it.
//
//     TEST_F(ServerTest, ...) { start(); EXPECT_EQ(request(http::verb::get, "/").result_int(), 200); }

#include "engine/base/error.hpp"
#include "server/net/server.hpp"
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
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
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

    void start(bool playing = false, Server::Options options = {}, Scene scene = box_scene(), Session::Settings settings = {}) {
        serve(std::make_unique<Session>(std::move(scene), playing, std::move(settings)), std::move(options));
    }
    void serve(std::unique_ptr<Session> session, Server::Options options = {}) {
        options.port = 0;
        session_ = std::move(session);
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

}  // namespace tetfront
