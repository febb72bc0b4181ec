// The only translation unit that includes Boost.Beast: it takes half a minute and a gigabyte to compile.
//
// Everything here runs on the thread that called run(), so nothing is locked but the slot for the newest frame. A
// connection has one read and one write in flight at most.

#include "server/net/server.hpp"

#include "engine/base/error.hpp"
#include "server/net/access.hpp"
#include "server/net/command_parser.hpp"
#include "server/net/outbox.hpp"
#include "server/net/protocol.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <spdlog/spdlog.h>

namespace tetfront {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using namespace std::chrono_literals;

constexpr std::size_t max_header_bytes = 8 * 1024;
constexpr std::size_t hard_message_limit = 1024 * 1024;  // a message above closes the connection with 1009
constexpr int max_commands_per_second = 1000;            // of one connection
constexpr int send_buffer_bytes = 256 * 1024;            // the kernel would hide seconds of frames from a slow client
constexpr auto close_timeout = 2s;

// The client is scripts, styles and a worker of our own files; nothing inline, nothing from elsewhere.
constexpr const char* content_security_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; "
    "connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

struct Connection {
    virtual ~Connection() = default;
    virtual void shut_down() = 0;  // ends soon, and then calls Hub::remove
};
class WebSocketConnection;

/// What the connections share.
struct Hub {
    Hub(Server::Options options_, WebFiles files_, Session& session_)
        : options(std::move(options_)), files(std::move(files_)), session(session_) {}

    Server::Options options;
    WebFiles files;
    Session& session;
    asio::io_context io{1};
    std::optional<AccessPolicy> access;
    std::set<std::shared_ptr<Connection>> connections;
    std::set<std::shared_ptr<WebSocketConnection>> viewers;
    ClientId last_client = 0;
    asio::steady_timer shutdown_deadline{io};
    bool stopping = false;

    // The session as last heard of. A viewer is greeted once all three are there.
    std::shared_ptr<const Model> model;
    std::shared_ptr<const Frame> frame;
    std::optional<SessionState> state;
    SharedBytes progress;

    /// The present frame's messages; encoded when somebody wants them.
    std::shared_ptr<const Moment> moment();
    [[nodiscard]] bool ready() const { return model && frame && state; }
    void greet(WebSocketConnection& viewer);
    void add(const std::shared_ptr<WebSocketConnection>& viewer);
    void remove(const std::shared_ptr<Connection>& connection);
    void remove_viewer(const std::shared_ptr<WebSocketConnection>& viewer);
    void broadcast_state();

    void on_progress(const std::string& what, double fraction);
    void on_frame(std::shared_ptr<const Frame> newest);
    void on_state(const SessionState& newest);

 private:
    std::shared_ptr<const Moment> encoded_;
    std::shared_ptr<const Frame> encoded_frame_;
    std::uint32_t sequence_ = 0;
    std::string last_stage_;
};

class WebSocketConnection : public Connection, public std::enable_shared_from_this<WebSocketConnection> {
 public:
    WebSocketConnection(Hub& hub, beast::tcp_stream stream)
        : hub_(hub), stream_(std::move(stream)), close_deadline_(hub.io), client_(++hub.last_client) {}

    void accept(const http::request<http::empty_body>& request) {
        beast::get_lowest_layer(stream_).expires_never();  // the WebSocket has timeouts of its own
        stream_.set_option(
            websocket::stream_base::timeout{hub_.options.request_timeout, hub_.options.idle_timeout, true});
        stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
            response.set(http::field::sec_websocket_protocol,
                         beast::string_view(subprotocol.data(), subprotocol.size()));
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
            self->hub_.add(self);
            self->read();
            if (self->hub_.stopping) self->shut_down();
        });
    }

    Outbox& outbox() { return outbox_; }
    void push(std::string text) {
        if (!outbox_.push(std::move(text))) close(websocket::close_code::policy_error, "answers are not being read");
    }
    /// After a change of the outbox.
    void flush() {
        if (writing_ || closing_) return;
        std::optional<OutgoingMessage> message = outbox_.next();
        if (!message) return;
        writing_ = true;
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
    void read() {
        // Of a message that is too large only the fact is kept.
        const std::size_t room = max_message_bytes + 1 - buffer_.size();
        stream_.async_read_some(buffer_, room, [self = shared_from_this()](Error error, std::size_t) {
            if (error) return self->finish();
            self->on_part();
        });
    }

    void on_part() {
        if (buffer_.size() > max_message_bytes) {
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
        if (too_large_) return answer(std::nullopt, CommandError{"too_large", "", "is larger than 64 KiB"});
        if (!stream_.got_text()) return answer(std::nullopt, CommandError{"malformed", "", "is not a text message"});
        const auto data = buffer_.data();
        ParsedCommand parsed = parse_command({static_cast<const char*>(data.data()), data.size()});
        if (!within_rate())
            return answer(parsed.id, CommandError{"too_many", "", "more than 1000 commands within a second"});
        if (const auto* error = std::get_if<CommandError>(&parsed.result)) return answer(parsed.id, *error);
        hub_.session.submit(client_, std::move(std::get<Command>(parsed.result)),
                            [weak = weak_from_this(), id = parsed.id, &io = hub_.io](const auto& error) {
                                asio::post(io, [weak, id, error] {
                                    if (const auto self = weak.lock()) self->answer(id, error);
                                });
                            });
    }

    void answer(std::optional<std::int64_t> id, const std::optional<CommandError>& error) {
        push(error ? error_reply(id, *error) : ok_reply(id.value_or(0)));
        flush();
    }

    bool within_rate() {
        const auto now = std::chrono::steady_clock::now();
        if (now - rate_since_ >= 1s) {
            rate_since_ = now;
            rate_count_ = 0;
        }
        return ++rate_count_ <= max_commands_per_second;
    }

    /// The closing handshake; a client that does not take part in it is dropped.
    void close(websocket::close_code code, const char* reason) {
        if (closing_) return;
        closing_ = true;
        stream_.async_close({code, reason}, [self = shared_from_this()](Error) {});
        close_deadline_.expires_after(close_timeout);
        close_deadline_.async_wait([self = shared_from_this()](Error error) {
            if (!error) self->drop();
        });
    }

    void drop() { beast::get_lowest_layer(stream_).close(); }

    /// Nothing will be read any more.
    void finish() {
        closing_ = true;
        close_deadline_.cancel();
        hub_.session.disconnect(client_);
        hub_.remove_viewer(shared_from_this());
    }

    Hub& hub_;
    websocket::stream<beast::tcp_stream> stream_;
    asio::steady_timer close_deadline_;
    ClientId client_;
    Outbox outbox_;
    beast::flat_buffer buffer_;
    bool open_ = false, writing_ = false, closing_ = false, too_large_ = false;
    std::chrono::steady_clock::time_point rate_since_{};
    int rate_count_ = 0;
};

class HttpConnection : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
    HttpConnection(Hub& hub, tcp::socket socket) : hub_(hub), stream_(std::move(socket)) {}

    void read() {
        parser_.emplace();
        parser_->header_limit(max_header_bytes);
        stream_.expires_after(hub_.options.request_timeout);
        http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
            if (!error)
                self->on_request();
            else if (error == http::error::header_limit || error == http::error::buffer_overflow)
                self->refuse(http::status::request_header_fields_too_large, "the request's header is too large", false);
            else if (error.category() == make_error_code(http::error::bad_method).category() &&
                     error != http::error::end_of_stream && error != http::error::partial_message)
                self->refuse(http::status::bad_request, "the request is not HTTP", false);
            else
                self->finish();
        });
    }

    void shut_down() override { stream_.close(); }

 private:
    using Response = http::response<http::string_body>;

    void on_request() {
        const http::request<http::empty_body>& request = parser_->get();
        // A body would have to be skipped to find the next request; no request here has any.
        const bool keep_alive = request.keep_alive() && parser_->is_done();
        const auto hosts = request.count(http::field::host);
        if (hosts != 1 || !hub_.access->host_allowed(text(request[http::field::host])))
            return refuse(http::status::forbidden, "this server does not go by that Host", keep_alive);
        const auto origins = request.count(http::field::origin);
        if (origins > 1 || (origins == 1 && !hub_.access->origin_allowed(text(request[http::field::origin]))))
            return refuse(http::status::forbidden, "pages of another Origin may not use this server", keep_alive);
        if (request.method() != http::verb::get && request.method() != http::verb::head) {
            Response response = make(http::status::method_not_allowed, "use GET or HEAD\n", keep_alive);
            response.set(http::field::allow, "GET, HEAD");
            return send(std::move(response));
        }
        if (request.target() == "/ws") return on_websocket(keep_alive);
        const WebFile* file = find(hub_.files, text(request.target()));
        if (!file) return refuse(http::status::not_found, "there is no such page", keep_alive);
        send_file(*file, keep_alive);
    }

    void on_websocket(bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        if (!websocket::is_upgrade(request)) {
            Response response =
                make(http::status::upgrade_required, "this address speaks WebSocket only\n", keep_alive);
            response.set(http::field::upgrade, "websocket");
            return send(std::move(response));
        }
        const http::token_list offered(request[http::field::sec_websocket_protocol]);
        if (std::none_of(offered.begin(), offered.end(), [](auto name) { return text(name) == subprotocol; }))
            return refuse(http::status::bad_request, "offer the WebSocket subprotocol tetfront.v1", keep_alive);
        if (buffer_.size() > 0)
            return refuse(http::status::bad_request, "bytes follow the request before it was answered", false);
        const auto viewer = std::make_shared<WebSocketConnection>(hub_, std::move(stream_));
        hub_.connections.insert(viewer);
        hub_.remove(shared_from_this());
        viewer->accept(request);
    }

    void send_file(const WebFile& file, bool keep_alive) {
        const http::request<http::empty_body>& request = parser_->get();
        const bool unchanged = request[http::field::if_none_match] == file.etag;
        const bool head = request.method() == http::verb::head;
        Response response = make(unchanged ? http::status::not_modified : http::status::ok,
                                 unchanged || head ? std::string() : file.bytes, keep_alive);
        response.set(http::field::content_type, file.content_type);
        response.set(http::field::etag, file.etag);
        response.set(http::field::cache_control, file.cache_control);
        if (head) response.content_length(file.bytes.size());
        send(std::move(response));
    }

    Response make(http::status status, std::string body, bool keep_alive) {
        Response response(status, 11);
        response.keep_alive(keep_alive);
        response.set(http::field::server, "tetfront");
        response.set(http::field::content_type, "text/plain; charset=utf-8");
        response.set(http::field::cache_control, "no-store");
        response.set("Content-Security-Policy", content_security_policy);
        response.set("X-Content-Type-Options", "nosniff");
        response.set("X-Frame-Options", "DENY");
        response.set("Referrer-Policy", "no-referrer");
        response.set("Cross-Origin-Opener-Policy", "same-origin");
        response.set("Cross-Origin-Resource-Policy", "same-origin");
        response.body() = std::move(body);
        response.prepare_payload();
        return response;
    }

    void refuse(http::status status, std::string_view why, bool keep_alive) {
        std::string body(why);
        if (parser_->get().method() == http::verb::head)
            body.clear();
        else
            body += '\n';
        send(make(status, std::move(body), keep_alive));
    }

    void send(Response response) {
        response_ = std::move(response);
        stream_.expires_after(hub_.options.request_timeout);
        http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
            if (error)
                self->finish();
            else if (self->response_.need_eof())
                self->linger();
            else
                self->read();
        });
    }

    /// Lets the client read the answer: closing at once while it still sends would reset the connection.
    void linger() {
        Error ignored;  // gone already: then the read below says so
        stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        stream_.expires_after(close_timeout);
        skip();
    }
    void skip() {
        stream_.async_read_some(asio::buffer(skipped_), [self = shared_from_this()](Error error, std::size_t) {
            if (error)
                self->finish();
            else
                self->skip();
        });
    }

    void finish() {
        stream_.close();
        hub_.remove(shared_from_this());
    }

    static std::string_view text(beast::string_view s) { return {s.data(), s.size()}; }

    Hub& hub_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{2 * max_header_bytes};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Response response_;
    std::array<char, 4096> skipped_{};
};

std::shared_ptr<const Moment> Hub::moment() {
    if (encoded_frame_ == frame) return encoded_;
    constexpr std::uint16_t generation = 1;  // one model per process so far
    auto next = std::make_shared<Moment>();
    next->generation = generation;
    next->epoch = frame->topology->epoch;
    next->model = encoded_ ? encoded_->model : share(encode_model(*frame->model, generation));
    next->topology = encoded_ && encoded_frame_->topology == frame->topology
                         ? encoded_->topology
                         : share(encode_topology(*frame->topology, frame->front_positions.size(), generation));
    next->frame = share(encode_frame(*frame, generation, ++sequence_));
    encoded_ = std::move(next);
    encoded_frame_ = frame;
    return encoded_;
}

void Hub::greet(WebSocketConnection& viewer) {
    viewer.push(hello_event(model->scene, *model->frame_model, *state));
    viewer.outbox().set_progress(nullptr);
    viewer.outbox().show(moment());
    viewer.flush();
}

void Hub::add(const std::shared_ptr<WebSocketConnection>& viewer) {
    viewers.insert(viewer);
    if (ready())
        greet(*viewer);
    else
        viewer->outbox().set_progress(progress);
    broadcast_state();
    viewer->flush();
}

void Hub::remove_viewer(const std::shared_ptr<WebSocketConnection>& viewer) {
    if (viewers.erase(viewer) > 0) broadcast_state();
    remove(viewer);
}

void Hub::remove(const std::shared_ptr<Connection>& connection) {
    connections.erase(connection);
    if (stopping && connections.empty()) shutdown_deadline.cancel();
}

void Hub::broadcast_state() {
    if (!ready() || viewers.empty()) return;
    const SharedBytes bytes = share(state_event(*state, viewers.size()));
    for (const auto& viewer : viewers) {
        viewer->outbox().set_state(bytes);
        viewer->flush();
    }
}

void Hub::on_progress(const std::string& what, double fraction) {
    if (what != last_stage_) spdlog::info("building the model: {}", what);
    last_stage_ = what;
    progress = share(progress_event(what, fraction));
    for (const auto& viewer : viewers) {
        viewer->outbox().set_progress(progress);
        viewer->flush();
    }
}

void Hub::on_frame(std::shared_ptr<const Frame> newest) {
    frame = std::move(newest);
    if (!ready() || viewers.empty()) return;
    const auto present = moment();
    for (const auto& viewer : viewers) {
        viewer->outbox().show(present);
        viewer->flush();
    }
}

void Hub::on_state(const SessionState& newest) {
    const bool was_ready = ready();
    state = newest;
    if (!was_ready && ready())
        for (const auto& viewer : viewers) greet(*viewer);
    broadcast_state();
}

std::string reason(const Error& error) { return error.message(); }

}  // namespace

struct Server::Impl {
    Hub hub;
    tcp::acceptor acceptor;
    asio::signal_set signals;
    asio::steady_timer accept_pause;
    std::exception_ptr failure;

    std::mutex mutex;
    std::shared_ptr<const Frame> newest;  // guarded by mutex: the slot that the session's thread drops frames into

    Impl(Options options, WebFiles files, Session& session)
        : hub(std::move(options), std::move(files), session), acceptor(hub.io), signals(hub.io), accept_pause(hub.io) {
        listen();
    }

    void listen() {
        const std::string& host = hub.options.host;
        Error error;
        const auto address = asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, error);
        if (error) throw InputError("--host", host, "is not an address", "use one such as 127.0.0.1, ::1 or localhost");
        const tcp::endpoint endpoint(address, hub.options.port);
        acceptor.open(endpoint.protocol(), error);
        if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
        if (!error) acceptor.bind(endpoint, error);
        if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
        const std::string where = host_and_port(host, hub.options.port);
        if (error == asio::error::address_in_use)
            throw PortTaken("another program listens on " + where +
                            " already; stop it, or use another --port (0: any)");
        if (error)
            throw InputError("", "", "cannot listen on " + where + ": " + reason(error),
                             "use another --host or --port");
        hub.access.emplace(host, port());
    }

    [[nodiscard]] std::uint16_t port() const { return acceptor.local_endpoint().port(); }

    void accept() {
        acceptor.async_accept([this](Error error, tcp::socket socket) {
            if (hub.stopping) return;
            if (error == asio::error::no_descriptors || error == asio::error::no_memory) {
                spdlog::warn("cannot accept a connection: {}", reason(error));
                accept_pause.expires_after(200ms);
                accept_pause.async_wait([this](Error e) {
                    if (!e) accept();
                });
                return;
            }
            accept();
            if (!error && hub.connections.size() < hub.options.max_connections) begin(std::move(socket));
        });
    }

    void begin(tcp::socket socket) {
        Error ignored;  // both are for speed only
        socket.set_option(tcp::no_delay(true), ignored);
        socket.set_option(asio::socket_base::send_buffer_size(send_buffer_bytes), ignored);
        const auto connection = std::make_shared<HttpConnection>(hub, std::move(socket));
        hub.connections.insert(connection);
        connection->read();
    }

    void stop() {
        if (std::exchange(hub.stopping, true)) return;
        acceptor.close();
        accept_pause.cancel();
        signals.cancel();
        if (hub.connections.empty()) return;
        // Should a connection ever not end by itself.
        hub.shutdown_deadline.expires_after(close_timeout + 1s);
        hub.shutdown_deadline.async_wait([this](Error error) {
            if (!error) hub.io.stop();
        });
        for (const auto& connection : std::set(hub.connections)) connection->shut_down();
    }

    /// The session's thread calls these.
    Session::Listener listener() {
        auto& io = hub.io;
        return {.progress = [this, &io](
                                const std::string& what,
                                double fraction) { asio::post(io, [=, this] { hub.on_progress(what, fraction); }); },
                .model = [this, &io](auto model) { asio::post(io, [=, this] { hub.model = model; }); },
                .frame =
                    [this](auto frame) {
                        const std::lock_guard lock(mutex);
                        if (!std::exchange(newest, std::move(frame))) asio::post(hub.io, [this] { take_frame(); });
                    },
                .state = [this, &io](const SessionState& state) { asio::post(io, [=, this] { hub.on_state(state); }); },
                .build_failed =
                    [this, &io](std::exception_ptr error) {
                        asio::post(io, [=, this] {
                            failure = error;
                            stop();
                        });
                    }};
    }

    void take_frame() {
        std::shared_ptr<const Frame> frame;
        {
            const std::lock_guard lock(mutex);
            frame = std::exchange(newest, nullptr);
        }
        hub.on_frame(std::move(frame));
    }

    void run() {
        if (hub.options.signals) {
            signals.add(SIGINT);
            signals.add(SIGTERM);
            signals.async_wait([this](Error error, int) {
                if (!error) stop();
            });
        }
        accept();
        hub.session.start(listener());
        for (bool running = true; running;) {
            try {
                hub.io.run();
                running = false;
            } catch (const std::exception& e) {  // of one connection's handler: the others go on
                spdlog::error("while serving: {}", e.what());
            }
        }
        hub.session.stop();
        if (failure) std::rethrow_exception(failure);
    }
};

Server::Server(Options options, WebFiles files, Session& session)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(files), session)) {}

Server::~Server() = default;

std::uint16_t Server::port() const { return impl_->port(); }

std::string Server::url() const { return "http://" + host_and_port(impl_->hub.options.host, port()) + "/"; }

void Server::run() { impl_->run(); }

void Server::stop() {
    asio::post(impl_->hub.io, [impl = impl_.get()] { impl->stop(); });
}

}  // namespace tetfront
