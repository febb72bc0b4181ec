#pragma once
// Turns a sequence of PNG files into a video with ffmpeg, when there is one.
//
//     const VideoJob job{.directory = "frames", .first = 0, .count = 120, .fps = 30, .even = true, .file = "frames.mp4"};
//     std::puts(command_line(job).c_str());
//     if (!run_ffmpeg(job)) ...                   // there is no ffmpeg

#include "server/base/child.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

struct VideoJob {
    std::filesystem::path directory;
    int first = 0, count = 0;
    double fps = 30;
    bool even = true;  // width and height are; H.264 in yuv420p, which all players show, needs it
    std::string file;  // to write; empty: named after the directory. Endless pictures: .webp, .apng, .gif; else H.264
};

/// The words of the command.
std::vector<std::string> ffmpeg_command(const VideoJob& job);
/// The same for a shell.
std::string command_line(const VideoJob& job);
/// False: there is no ffmpeg in PATH. Throws OutputError when it fails.
bool run_ffmpeg(const VideoJob& job);

/// A video of pictures that come one by one, on standard output: fragments of MP4, which need no way back in the file.
class VideoStream {
 public:
    /// threads: for ffmpeg; 0: as it likes. Throws OutputError when there is no ffmpeg. SIGPIPE must be ignored.
    VideoStream(double fps, bool even, int threads);

    /// Throws OutputError.
    void add(std::string_view png);
    /// Throws OutputError when ffmpeg failed.
    void finish();

 private:
    Pipe pipe_ = make_pipe();
    std::unique_ptr<Child> ffmpeg_;
};

std::string shell_quoted(const std::string& word);

}  // namespace tetfront
