#pragma once
// A sequence of PNG files: simulate, render and encode overlap, each on a thread of its own.
//
//     SequenceReport report = render_sequence(
//         {.frames = 120, .directory = "frames", .view = view, .title = "Bunny"},
//         [&](int index) { step_until(index); return simulation.frame(); },
//         [](int written) { return !stop; });
//
// Files appear in order and only when complete, so whatever ends the work, frames 0..k are whole.

#include "engine/simulation/frame.hpp"
#include "server/render/png.hpp"
#include "server/render/view.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetfront {

struct SequenceOptions {
    int frames = 1;            // of the whole sequence, >= 1
    std::vector<int> numbers;  // of those to write, ascending in [0, frames); empty: all
    std::filesystem::path directory;
    /// Takes each picture, on a thread of its own, in order; empty: files in the directory do.
    std::function<void(const std::string& name, std::string_view png)> write = {};
    View view;
    std::string title;
    bool turntable = false;    // one revolution over the whole sequence, on top of what the view's keyframes do
    int png_level = 1;                                      // 0..9
    std::vector<std::pair<std::string, std::string>> text;  // PNG text chunks; Frame and Time are added
};

struct SequenceReport {
    int written = 0;
    double seconds = 0;                           // wall clock
    double simulate = 0, render = 0, encode = 0;  // [s] each stage was at work, without waiting
};

/// Frame number `index`; called with the numbers in order on a thread that is neither the caller's nor the renderer's.
/// Null: there are no more.
using FrameSource = std::function<std::shared_ptr<const Frame>(int index)>;

/// Writes directory/000000.png and so on. `progress` is called on the calling thread after each file with the number
/// written so far; false ends the work early, after the files that are on their way.
/// Throws what the source throws, InputError for a view out of range, OutputError when a file cannot be written.
SequenceReport render_sequence(const SequenceOptions& options, const FrameSource& source,
                               const std::function<bool(int written)>& progress);

/// "000042.png"
std::string frame_name(int index);

/// Number of time steps [s] that take the simulation from 0 to the moment of frame `index`: the nearest whole number to
/// (start + index / fps) / time_step, so that rounding never adds up.
std::int64_t steps_until_frame(int index, double fps, double start, double time_step);

}  // namespace tetfront
