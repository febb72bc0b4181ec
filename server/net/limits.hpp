#pragma once
// How much clients may ask for; each is an option of `tetfront serve`.

#include <chrono>
#include <cstddef>

namespace tetfront {

/// Each has its error in server/PROTOCOL.md.
struct Limits {
    std::size_t connections = 320;              // of any kind; more are closed at once
    std::size_t clients = 256;                  // WebSockets; more are closed with 1013
    std::size_t connections_per_address = 256;  // 8 more are answered 429, WebSockets closed with 1013; more are closed at once
    int messages_per_second = 1000;             // of one client, 1..1e6
    std::size_t message_bytes = 64 * 1024;      // of one message of a client
    std::chrono::milliseconds stall{10'000};    // a simulation thread that is at one thing longer counts as stalled
};

}  // namespace tetfront
