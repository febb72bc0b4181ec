// The only translation unit that includes Boost.Beast: it takes half a minute and a gigabyte to compile.
//
// Everything here runs on the thread that called run(), so nothing is locked but the slot for the newest frame. A
// connection has one read and one write in flight at most.

#include "server/net/server.hpp"

#include "engine/base/error.hpp"
#include "server/net/access.hpp"
#include "server/net/http_connection.hpp"
#include "server/net/hub.hpp"
#include "server/net/thumbnails.hpp"
#include "server/net/websocket_connection.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <mutex>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <spdlog/spdlog.h>

namespace tetfront {

namespace {
constexpr int send_buffer_bytes = 256 * 1024;  // the kernel would hide seconds of frames from a slow client
constexpr std::size_t told_of_the_limit = 8;   // connections of one address
}

struct Server::Impl {
    const Options options;
    asio::io_context io{1};  // outlives all that is below
    tcp::acceptor acceptor{io};
    asio::signal_set signals{io};
    asio::steady_timer accept_pause{io}, shutdown_deadline{io};
    Hub hub;
    Thumbnails thumbnails;
    std::exception_ptr failure;
    std::chrono::steady_clock::time_point stopping_since{};

    std::mutex mutex;
    std::shared_ptr<const Shots> newest;  // guarded by mutex: the slot that the session's thread drops frames into

    Impl(Options options_, WebFiles files, Session& session)
        : options(std::move(options_)),
          hub(session, std::move(files), AccessPolicy(options.host, listen(), options.names, options.token), options.limits),
          thumbnails(io.get_executor(), session.settings().library) {
        hub.thumbnail = [this](const std::string& scene, Hub::ThumbnailDone done) { thumbnails.get(scene, std::move(done)); };
        // From here on, not from run() on: the port, and with it the URL, is known as soon as this exists.
        if (options.signals) {
            signals.add(SIGINT);
            signals.add(SIGTERM);
            // A terminal that closes, a reader of the log that ends, a file larger than ulimit -f: none takes the server
            // with it. What is written says so itself.
            for (const int signal : {SIGHUP, SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
        }
    }

    /// Returns the port.
    std::uint16_t listen() {
        const std::string& host = options.host;
        Error error;
        const auto address = asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, error);
        if (error) throw InputError("--host", host, "is not an address", "use one such as 127.0.0.1, ::1 or localhost");
        if (!is_loopback(host) && options.token.empty())
            throw InputError("--host", host, "can be reached from other machines, so a token is needed",
                             "give one with --token-file or in TETFRONT_TOKEN, for example from: openssl rand -hex 24");
        const tcp::endpoint endpoint(address, options.port);
        acceptor.open(endpoint.protocol(), error);
        if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
        if (!error) acceptor.bind(endpoint, error);
        if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
        const std::string where = host_and_port(host, options.port);
        if (error == asio::error::address_in_use)
            throw PortTaken("another program listens on " + where +
                            " already; stop it, or use another --port (0: any)");
        if (error)
            throw InputError("", "", "cannot listen on " + where + ": " + error.message(),
                             "use another --host or --port");
        return port();
    }

    [[nodiscard]] std::uint16_t port() const { return acceptor.local_endpoint().port(); }

    void accept() {
        acceptor.async_accept([this](Error error, tcp::socket socket) {
            if (hub.shutting_down()) return;
            if (error == asio::error::no_descriptors || error == asio::error::no_memory) {
                spdlog::warn("cannot accept a connection: {}", error.message());
                accept_pause.expires_after(200ms);
                accept_pause.async_wait([this](Error e) {
                    if (!e) accept();
                });
                return;
            }
            accept();
            if (error) return;
            ++hub.metrics.connections;
            if (hub.connection_count() < options.limits.connections) return begin(std::move(socket));
            ++hub.metrics.refused_connections;  // the socket closes here
        });
    }

    void begin(tcp::socket socket) {
        Error ignored;  // gone already: then its first read says so; the options are for speed only
        const std::string address = socket.remote_endpoint(ignored).address().to_string();
        // Who has more than his share is told so, but at most so many are: each may take its time to read it.
        if (hub.connections_of(address) >= options.limits.connections_per_address + told_of_the_limit) {
            ++hub.metrics.refused_connections;
            return;
        }
        socket.set_option(tcp::no_delay(true), ignored);
        socket.set_option(asio::socket_base::send_buffer_size(send_buffer_bytes), ignored);
        const auto connection = std::make_shared<HttpConnection>(
            hub, Timeouts{options.request_timeout, options.idle_timeout}, std::move(socket));
        connection->address = address;
        hub.add(connection);
        connection->read();
    }

    void stop() {
        if (hub.shutting_down()) return;
        acceptor.close();
        accept_pause.cancel();
        signals.cancel();
        stopping_since = std::chrono::steady_clock::now();
        hub.session.begin_stop();
        // Should a connection ever not end by itself.
        shutdown_deadline.expires_after(Timeouts::close);
        shutdown_deadline.async_wait([this](Error error) {
            if (!error) io.stop();
        });
        thumbnails.stop();
        hub.shut_down([this] { shutdown_deadline.cancel(); });
    }

    /// The session's thread calls these.
    Session::Listener listener() {
        return {.progress = [this](const std::string& what,
                                   double fraction) { asio::post(io, [=, this] { hub.on_progress(what, fraction); }); },
                .model = [this](auto model) { asio::post(io, [=, this] { hub.on_model(model); }); },
                .frame =
                    [this](const Shots& shots) {
                        const std::lock_guard lock(mutex);
                        if (!std::exchange(newest, std::make_shared<const Shots>(shots))) asio::post(io, [this] { take_frame(); });
                    },
                .state = [this](const SessionState& state) { asio::post(io, [=, this] { hub.on_state(state); }); },
                .build_failed =
                    [this](std::exception_ptr error) {
                        asio::post(io, [=, this] {
                            failure = error;
                            stop();
                        });
                    }};
    }

    void take_frame() {
        std::shared_ptr<const Shots> shots;
        {
            const std::lock_guard lock(mutex);
            shots = std::exchange(newest, nullptr);
        }
        hub.on_frame(*shots);
    }

    void run() {
        if (options.signals) {
            signals.async_wait([this](Error error, int) {
                if (!error) stop();
            });
        }
        accept();
        hub.session.start(listener());
        for (bool running = true; running;) {
            try {
                io.run();
                running = false;
            } catch (const std::exception& e) {  // of one connection's handler: the others go on
                spdlog::error("while serving: {}", e.what());
            }
        }
        end_threads();
        if (failure) std::rethrow_exception(failure);
    }

    /// Patience counts from the moment when all was told to stop.
    void end_threads() {
        if (!options.patience) return hub.session.stop();
        const auto until = stopping_since + *options.patience;
        const auto left = [&] {
            return std::max(std::chrono::milliseconds(100),
                            std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now()));
        };
        const std::string within = " has not ended within " + std::to_string(options.patience->count()) + " ms";
        if (!hub.session.stop_within(left())) throw StillBusy("the simulation thread" + within);
        if (!hub.end_pictures(left())) throw StillBusy("the picture that is being drawn" + within);
    }
};

Server::Server(Options options, WebFiles files, Session& session)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(files), session)) {}

Server::~Server() = default;

std::uint16_t Server::port() const { return impl_->port(); }

std::string Server::url() const { return "http://" + host_and_port(impl_->options.host, port()) + "/"; }

void Server::run() { impl_->run(); }

void Server::stop() {
    asio::post(impl_->io, [impl = impl_.get()] { impl->stop(); });
}

}  // namespace tetfront
