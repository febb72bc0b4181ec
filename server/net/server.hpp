#pragma once
// Serves one Session to browsers: the web client's files over HTTP, and the simulation over WebSocket (PROTOCOL.md).
// One thread, the one that calls run(), does all of it; the session's thread only drops its newest frame into a slot.
//
//     Session session(load_scene(file), true);
//     Server server({.port = 8080}, load_web_files("web/dist"), session);   // listens from here on
//     std::cout << server.url() << std::endl;
//     server.run();                                                         // until stop(), SIGINT or SIGTERM

#include "server/net/limits.hpp"
#include "server/net/web_files.hpp"
#include "server/session/session.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetfront {

/// Another program listens there.
struct PortTaken : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The session's thread still works: only the end of the process ends it.
struct StillBusy : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class Server {
 public:
    struct Options {
        std::string host = "127.0.0.1";  // an address, or localhost
        std::uint16_t port = 8080;       // 0: any free one
        bool signals = false;            // SIGINT and SIGTERM stop the server; SIGHUP, SIGPIPE, SIGXFSZ do nothing
        Limits limits = {};
        std::vector<std::string> names = {};  // further names of this server in Host and Origin, see AccessPolicy
        std::string token = {};               // that clients must know; needed beyond the loopback
        std::chrono::milliseconds request_timeout{10'000};  // for one whole request, and between two
        std::chrono::milliseconds idle_timeout{20'000};     // of a WebSocket: pinged after half of it, gone after all
        std::optional<std::chrono::milliseconds> patience = {};  // with a step or a stage of a build, when stopping; none: any time
    };

    /// Listens. Throws PortTaken; InputError for an address that cannot be listened on, or beyond the loopback without a
    /// token. `session` has not been started
    /// and outlives the server.
    Server(Options options, WebFiles files, Session& session);
    ~Server();

    [[nodiscard]] std::uint16_t port() const;
    [[nodiscard]] std::string url() const;  // "http://127.0.0.1:8080/"

    /// Starts the session, serves, and on stop closes every connection (WebSockets with 1001, for 2 s at most) and
    /// stops the session. Rethrows what made the first build of the model fail. Throws StillBusy, see Options::patience.
    void run();
    /// Any thread, also before run().
    void stop();

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetfront
