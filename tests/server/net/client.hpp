#pragma once
// A WebSocket client that speaks the protocol.
//
//     Client client(connect(), host());
//     client.command({{"id", 1}, {"command", "pause"}})["type"]      // "ok"

#include "tests/server/net/server_fixture.hpp"

#include <boost/beast/websocket.hpp>

namespace tetfront {

namespace websocket = beast::websocket;

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
    std::string authorization = {}, cookie = {};
};

class Client {
 public:
    Client(tcp::socket socket, std::string host, const Join& join = {}) : stream_(std::move(socket)) {
        stream_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
            if (!join.protocols.empty()) request.set(http::field::sec_websocket_protocol, join.protocols);
            if (!join.origin.empty()) request.set(http::field::origin, join.origin);
            if (!join.authorization.empty()) request.set(http::field::authorization, join.authorization);
            if (!join.cookie.empty()) request.set(http::field::cookie, join.cookie);
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
    /// The next message of a type.
    Json event(const std::string& type) {
        return until([&](const Message& m) { return m.text && m.json["type"] == type; }).json;
    }
    void acknowledge(const Message& frame) {
        send(Json({{"command", "ack"}, {"frame", frame.at<std::uint32_t>(8)}}).dump());
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

}  // namespace tetfront
