#pragma once
// One line on stderr that grows and says how long it still takes, when stderr is a terminal; nothing otherwise.
//
//     ProgressBar bar("steps");
//     for (int i = 0; i < n; ++i) bar.show(i + 1, n);      // "steps  [#####     ]  53 %  318/600, 4 s left"

#include "server/session/remaining_time.hpp"

#include <chrono>
#include <cstddef>
#include <string>

namespace tetfront {

class ProgressBar {
 public:
    explicit ProgressBar(std::string what);
    ~ProgressBar() { clear(); }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(std::size_t done, std::size_t total);
    /// The same for work that counts in fractions, e.g. build_model's progress.
    void show(const std::string& what, double fraction);
    /// Removes the line.
    void clear();

 private:
    std::string left(double fraction);
    void draw(const std::string& line, bool last);

    std::string what_;
    bool terminal_;
    bool drawn_ = false;
    RemainingTime remaining_;
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace tetfront
