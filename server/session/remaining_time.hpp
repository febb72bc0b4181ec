#pragma once
// How long something long still takes, from what it has done so far.
//
//     RemainingTime remaining;
//     if (auto seconds = remaining.of("meshing", 0.25)) ...       // a change of the name starts anew

#include <chrono>
#include <optional>
#include <string>

namespace tetfront {

class RemainingTime {
 public:
    using Clock = std::chrono::steady_clock;

    /// fraction: done, 0..1. Seconds to go at the mean rate since the stage began; nothing while that says too little.
    std::optional<double> of(const std::string& stage, double fraction, Clock::time_point now = Clock::now()) {
        if (stage != stage_) {
            stage_ = stage;
            begin_ = now;
            first_ = fraction;
        }
        const double elapsed = std::chrono::duration<double>(now - begin_).count(), done = fraction - first_;
        if (elapsed < 0.5 || !(done > 0.01)) return std::nullopt;
        return elapsed * (1 - fraction) / done;
    }

 private:
    std::string stage_;
    Clock::time_point begin_;
    double first_ = 0;
};

}  // namespace tetfront
