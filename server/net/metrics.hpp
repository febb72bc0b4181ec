#pragma once
// What happened since the server started, and the page that Prometheus reads (text format 0.0.4). Belongs to the serving
// thread.
//
//     metrics.frames_sent += 1;
//     std::string page = metrics_page(metrics, gauges, state);

#include "server/session/session.hpp"

#include <cstdint>
#include <map>
#include <string>

namespace tetfront {

struct Metrics {
    std::uint64_t connections = 0, refused_connections = 0;  // accepted; turned away by a limit
    std::uint64_t requests = 0, commands = 0, bytes_sent = 0;
    std::uint64_t frames_sent = 0, frames_dropped = 0;  // of clients that have gone; see Gauges for those that are there
    std::uint64_t frames_encoded = 0;
    double encode_seconds = 0;
    std::map<std::string, std::uint64_t> errors;  // by code of an answer, or HTTP status of 400 and more
};

/// The present moment.
struct Gauges {
    std::size_t connections = 0, viewers = 0;
    std::uint64_t frames_sent = 0, frames_dropped = 0;  // since the start
    std::size_t commands_waiting = 0;                   // for the simulation
    std::size_t answers_waiting = 0;                    // in all outboxes
    double simulation_busy = 0;                         // [s] that the simulation thread has been at one thing
};

/// state: null before the first.
std::string metrics_page(const Metrics& metrics, const Gauges& gauges, const SessionState* state);

}  // namespace tetfront
