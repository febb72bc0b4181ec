#include "server/cli/progress_bar.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace tetfront {

namespace {

std::string bar(double fraction) {
    constexpr int width = 30;
    const double clamped = std::clamp(fraction, 0.0, 1.0);
    const int filled = static_cast<int>(std::lround(clamped * width));
    std::string text = "  [" + std::string(static_cast<std::size_t>(filled), '#') +
                       std::string(static_cast<std::size_t>(width - filled), ' ') + "] ";
    const std::string percent = std::to_string(static_cast<int>(clamped * 100));
    return text + std::string(3 - percent.size(), ' ') + percent + " %";
}

}  // namespace

ProgressBar::ProgressBar(std::string what) : what_(std::move(what)), terminal_(::isatty(STDERR_FILENO) == 1) {}

void ProgressBar::clear() {
    if (std::exchange(drawn_, false)) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(std::size_t done, std::size_t total) {
    const double fraction = static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(total, 1));
    draw(what_ + bar(fraction) + "  " + std::to_string(done) + "/" + std::to_string(total) + left(fraction),
         done == total);
}

void ProgressBar::show(const std::string& what, double fraction) {
    const bool new_stage = std::exchange(what_, what) != what;
    draw(what_ + bar(std::isfinite(fraction) ? fraction : 0) + left(fraction), new_stage);
}

std::string ProgressBar::left(double fraction) {
    const auto seconds = remaining_.of(what_, fraction);
    if (!seconds || !(*seconds >= 1)) return "";
    const auto whole = static_cast<long>(std::ceil(*seconds));
    return whole < 120 ? ", " + std::to_string(whole) + " s left" : ", " + std::to_string((whole + 59) / 60) + " min left";
}

void ProgressBar::draw(const std::string& line, bool last) {
    if (!terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (!last && now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    drawn_ = true;
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
}

}  // namespace tetfront
