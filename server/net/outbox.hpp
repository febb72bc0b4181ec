#pragma once
// What waits to be sent to one client. A slow client misses frames, never order: the newest moment waits in one slot,
// answers wait in a bounded queue. Memory per client is bounded whatever the client does.
//
// A client that acknowledges frames never has more than two of them in flight, so that no buffer between here and there
// hides a lag, and a client that sleeps gets nothing until it wakes up.
//
//     outbox.show(moment);                       // replaces the moment that waits
//     if (!outbox.push(ok_reply(7))) close();    // too many answers wait: the client does not read
//     while (auto message = outbox.next()) send(*message);
//     outbox.acknowledge(sequence);              // the client has shown this frame

#include "engine/simulation/frame.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <compare>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tetfront {

using SharedBytes = std::shared_ptr<const std::string>;

inline SharedBytes share(std::string bytes) { return std::make_shared<const std::string>(std::move(bytes)); }

/// What a client wants its frames to be.
struct FrameKind {
    Field field = Field::none;  // whose values they come with, when the moment has them
    bool compressed = false;
    friend auto operator<=>(const FrameKind&, const FrameKind&) = default;
};

/// One moment; each of its messages is encoded once for all clients.
struct Moment {
    std::uint16_t generation = 0;  // of the model, from 1
    std::uint32_t epoch = 0;       // of the topology
    SharedBytes model, topology;
    std::uint32_t sequence = 0;  // of the frame
    std::function<SharedBytes(FrameKind)> frame;
};

struct OutgoingMessage {
    SharedBytes bytes;
    bool text = false;
};

class Outbox {
 public:
    using Clock = std::chrono::steady_clock;
    // More than can wait for one slow step (Session::max_queue), so that only a client that does not read gets there.
    static constexpr std::size_t max_controls = 8192;
    static constexpr std::size_t max_control_bytes = 4 << 20;  // besides one message of any size
    static constexpr std::size_t max_in_flight = 2;  // frames

    /// Text messages of which only the newest counts, sent in this order.
    enum class Slot : std::uint8_t { progress, settings, recording, state, link };

    /// A text message that must arrive, in order. false: the queue is full.
    [[nodiscard]] bool push(std::string text);
    /// All but progress wait for the first frame. null: nothing to send.
    void set(Slot slot, SharedBytes text) { slots_[static_cast<std::size_t>(slot)] = std::move(text); }
    void show(std::shared_ptr<const Moment> moment);
    void set_kind(FrameKind kind) { kind_ = kind; }
    [[nodiscard]] FrameKind kind() const { return kind_; }
    /// All from before a new hello is forgotten, but for answers.
    void restart();

    /// What to send next; nullopt: nothing. A frame comes after its own model and topology, each sent once.
    std::optional<OutgoingMessage> next(Clock::time_point now = Clock::now());

    /// The client has shown this frame and all before it. A number that was never sent is ignored.
    void acknowledge(std::uint32_t sequence, Clock::time_point now = Clock::now());

    struct Statistics {
        std::uint64_t sent = 0, dropped = 0;  // frames
        std::size_t in_flight = 0;            // sent and not acknowledged; 0 when the client never acknowledges
        std::optional<double> round_trip;     // [s] of the newest acknowledged frame, from its sending
    };
    [[nodiscard]] Statistics statistics() const;
    [[nodiscard]] std::size_t waiting() const { return controls_.size(); }

 private:
    struct InFlight {
        std::uint32_t sequence;
        Clock::time_point sent;
    };
    std::optional<SharedBytes> take(Slot first, Slot last);

    std::deque<SharedBytes> controls_;
    std::size_t control_bytes_ = 0;  // in controls_
    std::array<SharedBytes, 5> slots_;
    std::shared_ptr<const Moment> moment_;
    // The rest of a moment that has been begun. A newer moment waits for it: else a front that changes with every frame
    // would leave a slow client with topologies only.
    std::deque<SharedBytes> begun_;
    std::uint16_t sent_generation_ = 0;
    std::optional<std::uint32_t> sent_epoch_;
    FrameKind kind_;

    bool acknowledges_ = false;
    std::deque<InFlight> in_flight_;  // at most remembered_in_flight
    std::uint64_t sent_ = 0, dropped_ = 0;
    std::optional<double> round_trip_;
};

}  // namespace tetfront
