#pragma once
// One viewer: commands in, frames and answers out. Included by server.cpp only, see there.

#include "server/net/command_parser.hpp"
#include "server/net/exports.hpp"
#include "server/net/hub.hpp"
#include "server/net/protocol.hpp"

#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <spdlog/spdlog.h>

namespace tetfront {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using namespace std::chrono_literals;

struct Timeouts {
    std::chrono::milliseconds request, idle;
    static constexpr std::chrono::milliseconds download{3'600'000};  // for one whole export
    static constexpr std::chrono::milliseconds close{2000};  // for the other side to take part in closing
};

/// So many in each second, counted from the first.
class RateLimit {
 public:
    bool within(int most) {
        const auto now = std::chrono::steady_clock::now();
        if (now - since_ >= 1s) {
            since_ = now;
            count_ = 0;
        }
        return ++count_ <= most;
    }

 private:
    std::chrono::steady_clock::time_point since_{};
    int count_ = 0;
};

class WebSocketConnection : public Viewer, public std::enable_shared_from_this<WebSocketConnection> {
 public:
    /// protocol: that the client is told, of another version: it is closed at once. authorized: it has shown the token
    /// already, or none is needed.
    WebSocketConnection(Hub& hub, const Timeouts& timeouts, beast::tcp_stream stream, std::string protocol, bool authorized)
        : hub_(hub),
          timeouts_(timeouts),
          stream_(std::move(stream)),
          close_deadline_(stream_.get_executor()),
          client_(hub.new_client()),
          protocol_(std::move(protocol)),
          authorized_(authorized) {}

    void accept(const http::request<http::empty_body>& request) {
        beast::get_lowest_layer(stream_).expires_never();  // the WebSocket has timeouts of its own
        stream_.set_option(websocket::stream_base::timeout{timeouts_.request, timeouts_.idle, true});
        stream_.set_option(websocket::stream_base::decorator([protocol = protocol_](websocket::response_type& response) {
            response.set(http::field::sec_websocket_protocol, protocol);
            response.set(http::field::server, "tetfront");
        }));
        websocket::permessage_deflate no_compression;
        no_compression.server_enable = false;
        stream_.set_option(no_compression);
        stream_.auto_fragment(false);
        stream_.read_message_max(hard_message_limit);
        stream_.async_accept(request, [self = shared_from_this()](Error error) {
            if (error) return self->finish();
            self->open_ = true;
            self->enter();
            self->read();
            if (self->hub_.shutting_down()) self->shut_down();
        });
    }

    void push(std::string text) override {
        if (!outbox.push(std::move(text))) close(websocket::close_code::policy_error, "answers are not being read");
    }
    /// After a change of the outbox.
    void flush() override {
        if (writing_ || closing_) return;
        std::optional<OutgoingMessage> message = outbox.next();
        if (!message) return;
        writing_ = true;
        hub_.metrics.bytes_sent += message->bytes->size();
        stream_.text(message->text);
        const auto bytes = asio::buffer(*message->bytes);
        stream_.async_write(bytes,
                            [self = shared_from_this(), keep = std::move(message->bytes)](Error error, std::size_t) {
                                self->writing_ = false;
                                if (error) return self->drop();  // the read that is under way ends the connection
                                self->flush();
                            });
    }

    void shut_down() override {
        if (open_)
            close(websocket::close_code::going_away, "the server is shutting down");
        else
            drop();
    }

 private:
    static constexpr auto wrong_token = static_cast<websocket::close_code>(4001);

    /// Becomes a viewer, or is turned away, or is asked for the token first.
    void enter() {
        // Browsers hide why an upgrade was refused; the reason of a close they show.
        if (protocol_ != subprotocol) {
            ++hub_.metrics.errors["version"];
            return close(websocket::close_code::protocol_error, "this server speaks tetfront.v1");
        }
        if (hub_.viewer_count() >= hub_.limits.clients) return turn_away();
        if (hub_.connections_of(address) > hub_.limits.connections_per_address) {
            ++hub_.metrics.refused_connections;
            return close(websocket::close_code::try_again_later, "there are too many clients from this address");
        }
        if (authorized_) return hub_.add_viewer(shared_from_this());
        close_deadline_.expires_after(timeouts_.request);
        close_deadline_.async_wait([weak = weak_from_this()](Error error) {
            const auto self = weak.lock();
            if (!error && self && !self->authorized_) self->close(wrong_token, "a token is needed");
        });
    }

    void turn_away() {
        ++hub_.metrics.refused_connections;
        close(websocket::close_code::try_again_later, "there are too many clients");
    }

    void show_token(const ParsedCommand& parsed) {
        const auto* command = std::get_if<Command>(&parsed.result);
        const auto* token = command ? std::get_if<command::Token>(command) : nullptr;
        if (!token || !hub_.access.token_matches(token->value)) {
            ++hub_.metrics.errors["token"];
            return close(wrong_token, token ? "the token is wrong" : "a token is needed");
        }
        if (hub_.viewer_count() >= hub_.limits.clients) return turn_away();
        authorized_ = true;
        close_deadline_.cancel();
        hub_.add_viewer(shared_from_this());
        answer(parsed.id, std::nullopt);
    }

    void read() {
        // Of a message that is too large only the fact is kept.
        const std::size_t room = hub_.limits.message_bytes + 1 - buffer_.size();
        stream_.async_read_some(buffer_, room, [self = shared_from_this()](Error error, std::size_t) {
            if (error) return self->finish();
            self->on_part();
        });
    }

    void on_part() {
        if (buffer_.size() > hub_.limits.message_bytes) {
            too_large_ = true;
            buffer_.clear();
        }
        if (stream_.is_message_done()) {
            if (!closing_) on_message();
            buffer_.clear();
            too_large_ = false;
        }
        read();
    }

    void on_message() {
        try {
            take_message();
        } catch (const std::exception& error) {  // nothing that is left half done here keeps the connection alive
            spdlog::error("while answering a client: {}", error.what());
            close(websocket::close_code::internal_error, "the server could not answer");
        }
    }
    void take_message() {
        ++hub_.metrics.commands;
        const auto data = buffer_.data();
        ParsedCommand parsed =
            too_large_ ? refusal("too_large", "is larger than " + std::to_string(hub_.limits.message_bytes) + " bytes")
            : !stream_.got_text() ? refusal("malformed", "is not a text message")
                                  : parse_command({static_cast<const char*>(data.data()), data.size()});
        if (!authorized_) return show_token(parsed);
        const bool within = commands_.within(hub_.limits.messages_per_second);
        if (const auto* error = std::get_if<CommandError>(&parsed.result); error && within) return answer(parsed.id, *error);
        const auto* command = std::get_if<Command>(&parsed.result);
        if (command && std::holds_alternative<command::Acknowledge>(*command)) {
            outbox.acknowledge(std::get<command::Acknowledge>(*command).frame);
            return flush();
        }
        if (!within)
            return answer(parsed.id, CommandError{"too_many", "",
                                                  "more than " + std::to_string(hub_.limits.messages_per_second) +
                                                      " commands within a second"});
        if (answered_here(parsed.id.value_or(0), *command)) return;
        submitted_ = true;
        hub_.session.submit(
            client_, std::move(std::get<Command>(parsed.result)),
            [weak = weak_from_this(), id = parsed.id, executor = stream_.get_executor()](const auto& error) {
                asio::post(executor, [weak, id, error] {
                    if (const auto self = weak.lock()) self->answer(id, error);
                });
            });
    }

    static ParsedCommand refusal(const char* code, const std::string& message) {
        return {std::nullopt, CommandError{code, "", message}};
    }

    /// They read folders, which takes the serving thread's time.
    static bool is_listing(const Command& command) {
        return std::holds_alternative<command::Scenes>(command) || std::holds_alternative<command::States>(command) ||
               std::holds_alternative<command::Recordings>(command);
    }

    /// What needs no simulation.
    bool answered_here(std::int64_t id, const Command& command) {
        const Library& library = hub_.session.settings().library;
        if (const auto* colouring = std::get_if<command::Colouring>(&command)) {
            const auto& recorded = hub_.model() ? hub_.model()->recorded : std::nullopt;
            if (recorded && colouring->field != Field::none && colouring->field != recorded->field) {
                answer(id, CommandError{"failed", "/value", "was not recorded"});
                return true;
            }
            outbox.set_kind({colouring->field, outbox.kind().compressed});
            hub_.show_fields();
            push(ok_reply(id));
        } else if (const auto* compression = std::get_if<command::Compression>(&command)) {
            outbox.set_kind({outbox.kind().field, compression->on});
            push(ok_reply(id));
        } else if (std::holds_alternative<command::Token>(command)) {
            push(ok_reply(id));
        } else if (is_listing(command) && !listings_.within(most_listings)) {
            answer(id, CommandError{"too_many", "", "more than " + std::to_string(most_listings) + " lists within a second"});
        } else if (std::holds_alternative<command::Scenes>(command)) {
            push(scenes_reply(id, library.scenes()));
        } else if (std::holds_alternative<command::States>(command)) {
            push(states_reply(id, library.states()));
        } else if (std::holds_alternative<command::Recordings>(command)) {
            push(recordings_reply(id, library.recordings(), has_ffmpeg()));
        } else {
            return false;
        }
        flush();
        return true;
    }

    void answer(std::optional<std::int64_t> id, const std::optional<CommandError>& error) {
        if (error) ++hub_.metrics.errors[error->code];
        push(error ? error_reply(id, *error) : ok_reply(id.value_or(0)));
        flush();
    }

    /// The closing handshake; a client that does not take part in it is dropped.
    void close(websocket::close_code code, const char* reason) {
        if (closing_) return;
        closing_ = true;
        stream_.async_close({code, reason}, [self = shared_from_this()](Error) {});
        close_deadline_.expires_after(Timeouts::close);
        close_deadline_.async_wait([self = shared_from_this()](Error error) {
            if (!error) self->drop();
        });
    }

    void drop() { beast::get_lowest_layer(stream_).close(); }

    /// Nothing will be read any more. A write that waits for a client which has closed its side only would wait forever.
    void finish() {
        closing_ = true;
        close_deadline_.cancel();
        drop();
        if (submitted_) hub_.session.disconnect(client_);
        hub_.remove_viewer(shared_from_this());
    }

    static constexpr int most_listings = 10;  // a second
    static constexpr std::size_t hard_message_limit = 1024 * 1024;  // a message above closes the connection with 1009

    Hub& hub_;
    Timeouts timeouts_;
    websocket::stream<beast::tcp_stream> stream_;
    asio::steady_timer close_deadline_;
    ClientId client_;
    std::string protocol_;
    beast::flat_buffer buffer_;
    bool authorized_;
    bool open_ = false, writing_ = false, closing_ = false, too_large_ = false;
    bool submitted_ = false;  // the session knows this client
    RateLimit commands_, listings_;
};

}  // namespace tetfront
