#include "server/net/outbox.hpp"

namespace tetfront {

bool Outbox::push(std::string text) {
    if (controls_.size() >= max_controls) return false;
    controls_.push_back(share(std::move(text)));
    return true;
}

std::optional<OutgoingMessage> Outbox::next() {
    const auto front = [](std::deque<SharedBytes>& queue, bool text) {
        OutgoingMessage message{std::move(queue.front()), text};
        queue.pop_front();
        return message;
    };
    if (!controls_.empty()) return front(controls_, true);
    if (!begun_.empty()) return front(begun_, false);
    if (progress_) return OutgoingMessage{std::exchange(progress_, nullptr), true};
    // Before the next frame, or a slow client would never hear of the state; but after the first.
    if (state_ && sent_epoch_) return OutgoingMessage{std::exchange(state_, nullptr), true};
    if (!moment_) return std::nullopt;

    const auto moment = std::exchange(moment_, nullptr);
    const bool new_model = moment->generation != sent_generation_;
    if (new_model) begun_.push_back(moment->model);
    if (new_model || moment->epoch != sent_epoch_) begun_.push_back(moment->topology);
    begun_.push_back(moment->frame);
    sent_generation_ = moment->generation;
    sent_epoch_ = moment->epoch;
    return front(begun_, false);
}

}  // namespace tetfront
