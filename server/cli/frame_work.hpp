#pragma once
// What `render` and `record` share: a simulation stepped to the moments of frames, progress for people, Ctrl-C.
//
//     SimulatedFrames frames(model, {.fps = 30, .start_at = 0, .field = Field::none});
//     FrameProgress progress(120);
//     for (int i = 0; i < 120 && !frames.interrupted(); ++i) use(frames(i)), progress.show(i + 1);
//     frames.complain();

#include "engine/simulation/simulation.hpp"
#include "server/cli/progress_bar.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace tetfront {

constexpr int exit_interrupted = 130;  // what shells expect after Ctrl-C

/// While it lives, the first Ctrl-C asks for an end after the frames on their way; the second one kills.
class Interruption {
 public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Any thread.
    [[nodiscard]] bool asked() const { return asked_; }

 private:
    static inline std::atomic<bool> asked_ = false;
    static_assert(std::atomic<bool>::is_always_lock_free, "a signal's handler sets it");
    struct sigaction before_ {};
};

/// How far the work is: a bar on a terminal, a line every tenth elsewhere; nothing when quiet.
class FrameProgress {
 public:
    explicit FrameProgress(int total, bool quiet = false) : total_(total), quiet_(quiet) {}
    void show(int done);

 private:
    int total_;
    bool quiet_;
    ProgressBar bar_{""};
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Which moments frames show.
struct FrameTimes {
    double fps = 30, start_at = 0;  // [1/s], [s] simulated
    Field field = Field::none;      // that frames hold
};

/// --frames, --seconds and --start-at of a command.
void add_frame_options(CLI::App& command, std::string& frames, double& seconds, double& start_at);

/// Builds a model with a progress bar.
std::shared_ptr<const Model> build_with_progress(Scene scene, const CacheSettings& cache, bool quiet = false);

class SimulatedFrames {
 public:
    SimulatedFrames(const std::shared_ptr<const Model>& model, const FrameTimes& times);

    /// Frame number `index`; numbers must not descend. Null: interrupted before its moment was reached.
    std::shared_ptr<const Frame> operator()(int index);
    [[nodiscard]] bool interrupted() const { return interruption_.asked(); }
    /// One line on stderr when steps did not go well.
    void complain() const;

 private:
    Simulation simulation_;
    FrameTimes times_;
    double time_step_;
    std::int64_t steps_ = 0, troubled_steps_ = 0;
    Interruption interruption_;
};

/// --frames N or A-B, and --seconds: the numbers first..last of a sequence that has `total` frames (0: not known).
struct FrameNumbers {
    int first = 0, last = -1, total = 0;
};
/// available: how many frames there are at most; 0: any number. Throws InputError.
FrameNumbers parse_frame_numbers(const std::string& frames, double seconds, double fps, int available);

/// Throws InputError for a number that is not finite; CLI::Range lets nan pass.
void check_finite(const char* option, double value);

}  // namespace tetfront
