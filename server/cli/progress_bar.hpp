#pragma once
// One line on stderr that grows, when stderr is a terminal; nothing otherwise.
//
//     ProgressBar bar("steps");
//     for (int i = 0; i < n; ++i) bar.show(i + 1, n);      // "steps  [#####     ]  53 %  318/600"

#include <chrono>
#include <cstddef>
#include <string>

namespace tetfront {

class ProgressBar {
 public:
    explicit ProgressBar(std::string what);
    ~ProgressBar();  // removes the line
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(std::size_t done, std::size_t total);
    /// The same for work that counts in fractions, e.g. build_model's progress.
    void show(const std::string& what, double fraction);

 private:
    void draw(const std::string& line, bool last);

    std::string what_;
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace tetfront
