#pragma once
// A viewer for load: watches and acknowledges as a browser does, and measures. Many of them share one thread.
//
//     asio::io_context io;
//     const auto viewer = std::make_shared<WatchingClient>(io, server.port());
//     viewer->read(); viewer->drag();
//     io.run_for(10s);
//     quantile(viewer->latencies, 0.99)

#include <chrono>
#include <cstdint>
#include <cstring>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

namespace tetfront::testing {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

class WatchingClient : public std::enable_shared_from_this<WatchingClient> {
 public:
    using Json = nlohmann::json;

    WatchingClient(asio::io_context& io, unsigned short port) : stream_(io) {
        const std::string host = "127.0.0.1:" + std::to_string(port);
        stream_.next_layer().connect({asio::ip::make_address("127.0.0.1"), port});
        stream_.next_layer().set_option(tcp::no_delay(true));
        stream_.set_option(websocket::stream_base::decorator(
            [](websocket::request_type& request) { request.set(beast::http::field::sec_websocket_protocol, "tetfront.v1"); }));
        stream_.read_message_max(std::size_t{256} << 20);
        stream_.handshake(host, "/ws");
    }
    void read() {
        stream_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t size) {
            if (error) {
                self->lost = true;
                return;
            }
            self->bytes += size;
            self->on_message();
            self->buffer_.clear();
            self->read();
        });
    }
    void send(std::string text) {
        waiting_.push_back(std::move(text));
        write();
    }
    /// Grabs the first triangle and moves the cursor, again each time that a frame shows the last move.
    void drag() {
        dragging_ = true;
        send(R"({"id":1,"command":"pull_begin","pull":0,"triangle":0,"barycentric":[1,0,0],"target":[0,0,0]})");
        move();
    }

    std::uint64_t frames = 0, bytes = 0, backwards = 0, dropped = 0;
    bool lost = false;
    bool asleep = false;  // acknowledges nothing any more, as a browser's tab that is frozen: the network still answers pings
    std::vector<double> ages;       // [s] of frames, from their sending to their acknowledgement, as the server measures it
    std::vector<double> latencies;  // [s] from a move of the cursor to the first frame that a step has made with it
    std::vector<double> rates;      // [1/s] steps

 private:
    void move() {
        target_ = 0.01F * static_cast<float>(++moves_ % 10 + 1);
        moved_ = Clock::now();
        moved_at_ = last_time_;
        send(Json({{"id", 1 + moves_}, {"command", "pull_move"}, {"pull", 0}, {"target", {target_, target_, target_}}}).dump());
    }
    template <class T>
    T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, static_cast<const char*>(buffer_.data().data()) + offset, sizeof value);
        return value;
    }
    void on_message() {
        if (!stream_.got_text()) return on_binary();
        const Json message = Json::parse(beast::buffers_to_string(buffer_.data()));
        if (message["type"] == "link") {
            dropped = message["dropped"];
            if (message["round_trip"].is_number()) ages.push_back(message["round_trip"]);
        } else if (message["type"] == "state" && message["steps_per_second"] > 0) {
            rates.push_back(message["steps_per_second"]);
        }
    }
    void on_binary() {
        if (at<std::uint8_t>(0) != 3) return;
        ++frames;
        const auto sequence = at<std::uint32_t>(8);
        if (sequence <= last_sequence_) ++backwards;
        last_sequence_ = sequence;
        last_time_ = at<double>(16);
        if (asleep) return;
        send("{\"command\":\"ack\",\"frame\":" + std::to_string(sequence) + "}");
        const auto pulls = at<std::uint32_t>(28);
        if (!dragging_ || pulls == 0 || last_time_ <= moved_at_) return;
        if (at<float>(buffer_.size() - 28 * pulls + 12) != target_) return;
        latencies.push_back(seconds_since(moved_));
        move();
    }
    void write() {
        if (writing_ || waiting_.empty()) return;
        writing_ = true;
        const auto text = std::make_shared<std::string>(std::move(waiting_.front()));
        waiting_.pop_front();
        stream_.text(true);
        stream_.async_write(asio::buffer(*text), [self = shared_from_this(), text](Error error, std::size_t) {
            self->writing_ = false;
            if (!error) self->write();
        });
    }

    websocket::stream<tcp::socket> stream_;
    beast::flat_buffer buffer_;
    std::deque<std::string> waiting_;
    bool writing_ = false, dragging_ = false;
    std::uint32_t last_sequence_ = 0;
    double last_time_ = 0, moved_at_ = 0;  // [s] simulated
    int moves_ = 0;
    float target_ = -1;
    Clock::time_point moved_;
};

}  // namespace tetfront::testing
