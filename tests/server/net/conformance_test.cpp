// RFC 6455 against the running server, byte by byte: what the Autobahn suite would send that matters here.

#include "tests/server/net/server_fixture.hpp"

#include <array>
#include <boost/asio/read_until.hpp>
#include <optional>

namespace tetfront {
namespace {

struct ReceivedFrame {
    int opcode;
    bool fin;
    std::string payload;
    [[nodiscard]] int close_code() const {
        return payload.size() < 2 ? -1 : static_cast<unsigned char>(payload[0]) * 256 + static_cast<unsigned char>(payload[1]);
    }
};

constexpr int text = 1, close_frame = 8, ping = 9, pong = 10;

/// A frame of a client, masked as it must be. first: overrides the first byte.
std::string frame(int opcode, std::string_view payload, bool fin = true, bool masked = true, int reserved = 0) {
    std::string bytes;
    bytes += static_cast<char>((fin ? 0x80 : 0) | (reserved << 4) | opcode);
    const int mask_bit = masked ? 0x80 : 0;
    if (payload.size() < 126) {
        bytes += static_cast<char>(mask_bit | static_cast<int>(payload.size()));
    } else if (payload.size() < 65536) {
        bytes += static_cast<char>(mask_bit | 126);
        for (int shift : {8, 0}) bytes += static_cast<char>(payload.size() >> shift & 0xFF);
    } else {
        bytes += static_cast<char>(mask_bit | 127);
        for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(payload.size() >> shift & 0xFF);
    }
    constexpr std::array<unsigned char, 4> mask = {0x12, 0x34, 0x56, 0x78};
    if (masked) bytes.append(reinterpret_cast<const char*>(mask.data()), 4);
    for (std::size_t i = 0; i < payload.size(); ++i)
        bytes += static_cast<char>(static_cast<unsigned char>(payload[i]) ^ (masked ? mask[i % 4] : 0));
    return bytes;
}

std::string close_payload(int code, std::string_view reason = {}) {
    std::string payload;
    payload += static_cast<char>(code >> 8);
    payload += static_cast<char>(code & 0xFF);
    return payload + std::string(reason);
}

/// A WebSocket of which every byte is ours.
class RawSocket {
 public:
    RawSocket(tcp::socket socket, const std::string& host) : socket_(std::move(socket)) {
        send("GET /ws HTTP/1.1\r\nHost: " + host +
             "\r\nConnection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: tetfront.v1\r\n\r\n");
        Error error;
        const std::size_t length = asio::read_until(socket_, asio::dynamic_buffer(received_), "\r\n\r\n", error);
        head = received_.substr(0, length);
        received_.erase(0, length);
    }
    void send(std::string_view bytes) {
        Error ignored;  // the server may have closed already; then reading tells
        asio::write(socket_, asio::buffer(bytes), ignored);
    }
    /// nullopt: the connection has ended.
    std::optional<ReceivedFrame> read() {
        if (!fill(2)) return std::nullopt;
        const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(received_[i])); };
        EXPECT_EQ(byte(1) & 0x80, 0U) << "a server does not mask";
        EXPECT_EQ(byte(0) & 0x70, 0U) << "no reserved bits";
        std::size_t header = 2, length = byte(1) & 0x7F;
        if (length >= 126) {
            header = length == 126 ? 4 : 10;
            if (!fill(header)) return std::nullopt;
            length = 0;
            for (std::size_t i = 2; i < header; ++i) length = length << 8 | byte(i);
        }
        if (!fill(header + length)) return std::nullopt;
        ReceivedFrame result{static_cast<int>(byte(0) & 0x0F), (byte(0) & 0x80) != 0, received_.substr(header, length)};
        received_.erase(0, header + length);
        return result;
    }
    /// Reads on until a frame of this opcode comes, or the end.
    std::optional<ReceivedFrame> until(int opcode) {
        for (;;) {
            auto one = read();
            if (!one || one->opcode == opcode) return one;
        }
    }
    /// The answer to a command.
    Json answer(int id) {
        while (auto one = until(text)) {
            const Json message = Json::parse(one->payload);
            if (message.contains("id") && message["id"] == id) return message;
        }
        return {};
    }
    /// The code that the server closes with; -1: it ends without; 1005: a close without a code.
    int closed() {
        const auto end = until(close_frame);
        return !end ? -1 : end->payload.empty() ? 1005 : end->close_code();
    }

    std::string head;

 private:
    bool fill(std::size_t size) {
        Error error;
        if (received_.size() < size) asio::read(socket_, asio::dynamic_buffer(received_), asio::transfer_at_least(size - received_.size()), error);
        return received_.size() >= size;
    }
    tcp::socket socket_;
    std::string received_;
};

class ConformanceTest : public ServerTest {
 protected:
    void SetUp() override { start(); }
    RawSocket open() { return {connect(), host()}; }
    static std::string step(int id) { return R"({"id": )" + std::to_string(id) + R"(, "command": "pause"})"; }
};

TEST_F(ConformanceTest, TheHandshakeProvesThatItWasUnderstood) {
    const RawSocket socket = open();
    EXPECT_TRUE(socket.head.starts_with("HTTP/1.1 101 "));
    EXPECT_NE(socket.head.find("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos) << "RFC 6455, 1.3";
    EXPECT_NE(socket.head.find("Sec-WebSocket-Protocol: tetfront.v1"), std::string::npos);
    EXPECT_EQ(socket.head.find("Sec-WebSocket-Extensions"), std::string::npos);
}

TEST_F(ConformanceTest, AnotherVersionOrNoKeyIsRefused) {
    const std::string start = "GET /ws HTTP/1.1\r\nHost: " + host() + "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Protocol: tetfront.v1\r\n";
    for (const char* rest : {"Sec-WebSocket-Version: 8\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nConnection: close\r\n\r\n",
                             "Sec-WebSocket-Version: 13\r\nConnection: close\r\n\r\n"}) {
        const std::string answer = exchange(start + rest);
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 4")) << answer;
    }
}

TEST_F(ConformanceTest, MessagesOfAllLengthEncodings) {
    RawSocket socket = open();
    for (const std::size_t padding : {std::size_t{0}, std::size_t{100}, std::size_t{126}, std::size_t{5000}, std::size_t{65'400}}) {
        socket.send(frame(text, step(1) + std::string(padding, ' ')));
        EXPECT_EQ(socket.answer(1)["type"], "ok") << padding;
    }
}

TEST_F(ConformanceTest, FragmentsWithControlFramesBetween) {
    RawSocket socket = open();
    const std::string message = step(7);
    socket.send(frame(text, message.substr(0, 5), false));
    socket.send(frame(ping, "between"));
    socket.send(frame(0, "", false));
    socket.send(frame(pong, "not asked for"));
    socket.send(frame(0, message.substr(5, 4), false));
    const auto answer = socket.until(pong);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->payload, "between");
    socket.send(frame(0, message.substr(9)));
    EXPECT_EQ(socket.answer(7)["type"], "ok");
}

TEST_F(ConformanceTest, BytesOneByOne) {
    RawSocket socket = open();
    for (const char byte : frame(text, step(3))) socket.send({&byte, 1});
    EXPECT_EQ(socket.answer(3)["type"], "ok");
}

TEST_F(ConformanceTest, APingIsAnsweredWithItsPayload) {
    RawSocket socket = open();
    const std::string longest(125, 'p');
    for (const std::string& payload : {std::string(), std::string("\x00\xff\xfe", 3), longest}) {
        socket.send(frame(ping, payload));
        const auto answer = socket.until(pong);
        ASSERT_TRUE(answer);
        EXPECT_EQ(answer->payload, payload);
    }
}

TEST_F(ConformanceTest, ViolationsCloseWith1002) {
    const std::vector<std::pair<const char*, std::string>> violations = {
        {"not masked", frame(text, step(1), true, false)},
        {"reserved bit 1", frame(text, step(1), true, true, 4)},
        {"reserved bit 2", frame(text, step(1), true, true, 2)},
        {"reserved bit 3", frame(text, step(1), true, true, 1)},
        {"reserved opcode 3", frame(3, "")},
        {"reserved opcode 7", frame(7, "x")},
        {"reserved control opcode 11", frame(11, "")},
        {"reserved control opcode 15", frame(15, "")},
        {"continuation of nothing", frame(0, "x")},
        {"a new message within another", frame(text, "x", false) + frame(text, "y")},
        {"a fragmented ping", frame(ping, "x", false)},
        {"a ping of 126 bytes", frame(ping, std::string(126, 'x'))},
        {"a close of one byte", frame(close_frame, "x")},
        {"close code 999", frame(close_frame, close_payload(999))},
        {"close code 1004", frame(close_frame, close_payload(1004))},
        {"close code 1005", frame(close_frame, close_payload(1005))},
        {"close code 1006", frame(close_frame, close_payload(1006))},
        {"close code 2999", frame(close_frame, close_payload(2999))},
    };
    for (const auto& [what, bytes] : violations) {
        RawSocket socket = open();
        socket.send(bytes);
        EXPECT_EQ(socket.closed(), 1002) << what;
    }
    RawSocket socket = open();
    socket.send(frame(text, step(1)));
    EXPECT_EQ(socket.answer(1)["type"], "ok");
}

TEST_F(ConformanceTest, ClosesAreAnsweredWithTheirCode) {
    for (const int code : {1000, 1001, 1003, 1007, 1008, 1009, 1011, 3000, 4999}) {
        RawSocket socket = open();
        socket.send(frame(close_frame, close_payload(code, "bye")));
        EXPECT_EQ(socket.closed(), code);
        EXPECT_FALSE(socket.read()) << "nothing comes after";
    }
    RawSocket socket = open();
    socket.send(frame(close_frame, ""));
    const int empty = socket.closed();
    EXPECT_TRUE(empty == 1005 || empty == 1000) << empty;
}

TEST_F(ConformanceTest, TextThatIsNotUtf8ClosesWith1007) {
    const std::vector<std::string> bad = {"\xff", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\x80", "\xf5\x80\x80\x80"};
    for (const std::string& bytes : bad) {
        RawSocket socket = open();
        socket.send(frame(text, "{\"a\": \"" + bytes + "\"}"));
        EXPECT_EQ(socket.closed(), 1007);
    }
    RawSocket cut = open();  // ends in the middle of a character
    cut.send(frame(text, "\xce\xba\xe1\xbd"));
    EXPECT_EQ(cut.closed(), 1007);
    RawSocket reason = open();
    reason.send(frame(close_frame, close_payload(1000, "\xff")));
    const int code = reason.closed();
    EXPECT_TRUE(code == 1002 || code == 1007) << code;
}

TEST_F(ConformanceTest, ACharacterMayBeSplitBetweenFragments) {
    RawSocket socket = open();
    socket.send(frame(text, "{\"\xce", false));
    socket.send(frame(0, "\xba\": 1}"));
    const auto is_refusal = [&] {
        while (auto one = socket.until(text))
            if (Json::parse(one->payload)["type"] == "error") return true;
        return false;
    };
    EXPECT_TRUE(is_refusal()) << "it is a text, though no command";
}

TEST_F(ConformanceTest, ALengthBeyondTheLimitClosesWith1009) {
    RawSocket socket = open();
    std::string huge = "\x81\xff";
    huge += std::string("\x00\x00\x00\xff\x00\x00\x00\x00", 8) + "mask";  // says 1 TB
    socket.send(huge);
    EXPECT_EQ(socket.closed(), 1009);
    RawSocket negative = open();
    negative.send("\x81\xff" + std::string("\xff\xff\xff\xff\xff\xff\xff\xff", 8) + "mask");
    const int code = negative.closed();
    EXPECT_TRUE(code == 1002 || code == 1009) << code;
}

TEST_F(ConformanceTest, LengthsThatAreNotTheShortestCloseWith1002) {
    for (const std::string& head : {std::string("\x81\xfe\x00\x01", 4), std::string("\x81\xff\x00\x00\x00\x00\x00\x00\x00\x01", 10)}) {
        RawSocket socket = open();
        socket.send(head + "mask" + "x");
        EXPECT_EQ(socket.closed(), 1002);
    }
}

}  // namespace
}  // namespace tetfront
