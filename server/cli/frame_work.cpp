#include "server/cli/frame_work.hpp"

#include "engine/base/error.hpp"
#include "server/render/sequence.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace tetfront {

namespace {

constexpr int most_frames = 1'000'000;

std::string duration(double seconds) {
    char text[64];
    if (seconds < 90)
        std::snprintf(text, sizeof text, "%.0f s", seconds);
    else if (seconds < 5400)
        std::snprintf(text, sizeof text, "%.0f min", seconds / 60);
    else
        std::snprintf(text, sizeof text, "%.1f h", seconds / 3600);
    return text;
}

bool troubled(const StepReport& r) { return !r.converged || r.rejected || r.inverted_tets > 0; }

}  // namespace

Interruption::Interruption() {
    struct sigaction action {};
    action.sa_handler = [](int) { asked_ = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    asked_ = false;
    ::sigaction(SIGINT, &action, &before_);
}
Interruption::~Interruption() { ::sigaction(SIGINT, &before_, nullptr); }

void FrameProgress::show(int done) {
    if (quiet_) return;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double rate = done / std::max(seconds, 1e-9);
    char text[160];
    std::snprintf(text, sizeof text, "frame %d/%d  %.1f a second  %s left", done, total_, rate,
                  duration((total_ - done) / rate).c_str());
    if (::isatty(STDERR_FILENO)) return bar_.show(text, static_cast<double>(done) / total_);
    if (done * 10LL / total_ > (done - 1) * 10LL / total_) std::fprintf(stderr, "%s\n", text);
}

void add_frame_options(CLI::App& command, std::string& frames, double& seconds, double& start_at) {
    command.add_option("--frames", frames, "How many, or a part FIRST-LAST counted from 0")->type_name("N|A-B");
    command.add_option("--seconds", seconds, "How long, in simulated time")->check(CLI::Range(1e-6, 86'400.0));
    command.add_option("--start-at", start_at, "Simulated time of frame 0 [s]")
        ->check(CLI::Range(0.0, 86'400.0))
        ->capture_default_str();
}

std::shared_ptr<const Model> build_with_progress(Scene scene, const CacheSettings& cache, bool quiet) {
    if (quiet) return build_model(std::move(scene), {}, cache);
    ProgressBar bar("");
    return build_model(std::move(scene), [&bar](const std::string& what, double done) { bar.show(what, done); }, cache);
}

SimulatedFrames::SimulatedFrames(const std::shared_ptr<const Model>& model, const FrameTimes& times)
    : simulation_(model), times_(times), time_step_(model->scene.time_step) {}

std::shared_ptr<const Frame> SimulatedFrames::operator()(int index) {
    const std::int64_t until = steps_until_frame(index, times_.fps, times_.start_at, time_step_);
    for (; steps_ < until && !interruption_.asked(); ++steps_) troubled_steps_ += troubled(simulation_.step());
    if (steps_ < until) return nullptr;
    return simulation_.frame(0, times_.field);
}

void SimulatedFrames::complain() const {
    if (troubled_steps_ == 0) return;
    std::fprintf(stderr, "tetfront: %lld of %lld steps did not converge, were rejected or left inverted tets\n",
                 static_cast<long long>(troubled_steps_), static_cast<long long>(steps_));
}

FrameNumbers parse_frame_numbers(const std::string& frames, double seconds, double fps, int available) {
    FrameNumbers numbers;
    if (seconds > 0) numbers.total = static_cast<int>(std::clamp<double>(std::round(seconds * fps), 1, 2e9));
    const auto fail = [&](const std::string& problem) {
        throw InputError("--frames", frames, problem, "write a number from 1, or FIRST-LAST, counted from 0");
    };
    if (frames.empty()) {
        if (numbers.total == 0) numbers.total = available;
        if (numbers.total == 0) throw InputError("--frames", "", "is missing", "say how many, or use --seconds");
        numbers.last = numbers.total - 1;
    } else {
        const char* const end = frames.data() + frames.size();
        int first = 0, last = 0;
        auto [rest, error] = std::from_chars(frames.data(), end, first);
        if (error != std::errc{} || frames[0] == '-') fail("is not a number of frames");
        if (rest == end) {
            if (first < 1) fail("is less than 1");
            numbers.total = numbers.total ? std::min(numbers.total, first) : first;
            numbers.last = numbers.total - 1;
        } else {
            if (*rest != '-' || rest + 1 == end || rest[1] == '-') fail("is not a number of frames");
            const auto second = std::from_chars(rest + 1, end, last);
            if (second.ec != std::errc{} || second.ptr != end) fail("is not a number of frames");
            if (last < first) fail("ends before it begins");
            numbers.first = first, numbers.last = last;
        }
    }
    if (numbers.last >= most_frames) fail("goes beyond a million frames");
    if (available > 0) {
        if (numbers.first >= available) fail("begins after the last frame, " + std::to_string(available - 1));
        numbers.last = std::min(numbers.last, available - 1);
        numbers.total = available;
    } else if (numbers.total == 0) {
        numbers.total = numbers.last + 1;
    } else if (numbers.last >= numbers.total) {
        fail("goes beyond the end of --seconds");
    }
    return numbers;
}

void check_finite(const char* option, double value) {
    if (!std::isfinite(value)) throw InputError(option, "", "is not a number", "use a finite number");
}

}  // namespace tetfront
