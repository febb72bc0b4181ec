#include "server/net/outbox.hpp"

#include <algorithm>

namespace tetfront {

namespace {
// Of a client that has not acknowledged yet: its first acknowledgement may name any of these.
constexpr std::size_t remembered_in_flight = 64;
}  // namespace

bool Outbox::push(std::string text) {
    if (controls_.size() >= max_controls || control_bytes_ > max_control_bytes) return false;
    control_bytes_ += text.size();
    controls_.push_back(share(std::move(text)));
    return true;
}

void Outbox::show(std::shared_ptr<const Moment> moment) {
    if (moment_ && moment_ != moment) ++dropped_;
    moment_ = std::move(moment);
}

void Outbox::restart() {
    moment_ = nullptr;
    begun_.clear();
    in_flight_.clear();
    slots_ = {};
    sent_generation_ = 0;
    sent_epoch_.reset();
}

std::optional<SharedBytes> Outbox::take(Slot first, Slot last) {
    for (auto slot = static_cast<std::size_t>(first); slot <= static_cast<std::size_t>(last); ++slot)
        if (slots_[slot]) return std::exchange(slots_[slot], nullptr);
    return std::nullopt;
}

std::optional<OutgoingMessage> Outbox::next(Clock::time_point now) {
    const auto front = [](std::deque<SharedBytes>& queue, bool text) {
        OutgoingMessage message{std::move(queue.front()), text};
        queue.pop_front();
        return message;
    };
    if (!controls_.empty()) {
        control_bytes_ -= controls_.front()->size();
        return front(controls_, true);
    }
    if (!begun_.empty()) return front(begun_, false);
    if (auto text = take(Slot::progress, Slot::progress)) return OutgoingMessage{std::move(*text), true};
    // Before the next frame, or a slow client would never hear of the state; but after the first.
    if (sent_epoch_)
        if (auto text = take(Slot::settings, Slot::link)) return OutgoingMessage{std::move(*text), true};
    if (!moment_ || (acknowledges_ && in_flight_.size() >= max_in_flight)) return std::nullopt;

    const auto moment = std::exchange(moment_, nullptr);
    const bool new_model = moment->generation != sent_generation_;
    if (new_model) begun_.push_back(moment->model);
    if (new_model || moment->epoch != sent_epoch_) begun_.push_back(moment->topology);
    begun_.push_back(moment->frame(kind_));
    sent_generation_ = moment->generation;
    sent_epoch_ = moment->epoch;
    ++sent_;
    in_flight_.push_back({moment->sequence, now});
    if (in_flight_.size() > remembered_in_flight) in_flight_.pop_front();
    return front(begun_, false);
}

void Outbox::acknowledge(std::uint32_t sequence, Clock::time_point now) {
    const auto shown = std::ranges::find(in_flight_, sequence, &InFlight::sequence);
    if (shown == in_flight_.end()) return;
    acknowledges_ = true;
    round_trip_ = std::chrono::duration<double>(now - shown->sent).count();
    in_flight_.erase(in_flight_.begin(), shown + 1);
}

Outbox::Statistics Outbox::statistics() const {
    return {sent_, dropped_, acknowledges_ ? in_flight_.size() : 0, round_trip_};
}

}  // namespace tetfront
