#pragma once
// What waits to be sent to one client. A slow client misses frames, never order: the newest moment waits in one slot,
// answers wait in a bounded queue. Memory per client is bounded whatever the client does.
//
//     outbox.show(moment);                       // replaces the moment that waits
//     if (!outbox.push(ok_reply(7))) close();    // too many answers wait: the client does not read
//     while (auto message = outbox.next()) send(*message);

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tetfront {

using SharedBytes = std::shared_ptr<const std::string>;

inline SharedBytes share(std::string bytes) { return std::make_shared<const std::string>(std::move(bytes)); }

/// One moment, encoded once for all clients.
struct Moment {
    std::uint16_t generation = 0;  // of the model, from 1
    std::uint32_t epoch = 0;       // of the topology
    SharedBytes model, topology, frame;
};

struct OutgoingMessage {
    SharedBytes bytes;
    bool text = false;
};

class Outbox {
 public:
    // More than can wait for one slow step (Session::max_queue), so that only a client that does not read gets there.
    static constexpr std::size_t max_controls = 8192;

    /// A text message that must arrive, in order. false: the queue is full.
    [[nodiscard]] bool push(std::string text);
    /// Text messages of which only the newest counts.
    void set_progress(SharedBytes text) { progress_ = std::move(text); }
    void set_state(SharedBytes text) { state_ = std::move(text); }
    void show(std::shared_ptr<const Moment> moment) { moment_ = std::move(moment); }

    /// What to send next; nullopt: nothing. A frame comes after its own model and topology, each sent once.
    std::optional<OutgoingMessage> next();

 private:
    std::deque<SharedBytes> controls_;
    SharedBytes progress_, state_;
    std::shared_ptr<const Moment> moment_;
    // The rest of a moment that has been begun. A newer moment waits for it: else a front that changes with every frame
    // would leave a slow client with topologies only.
    std::deque<SharedBytes> begun_;
    std::uint16_t sent_generation_ = 0;
    std::optional<std::uint32_t> sent_epoch_;
};

}  // namespace tetfront
