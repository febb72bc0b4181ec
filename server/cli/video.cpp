#include "server/cli/video.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace tetfront {

std::string shell_quoted(const std::string& word) {
    if (!word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-/%+=:,@") ==
                             std::string::npos)
        return word;
    std::string quoted = "'";
    for (const char c : word) c == '\'' ? quoted += "'\\''" : quoted += c;
    return quoted + "'";
}

namespace {

/// What all players show.
std::vector<std::string> h264(bool even) {
    std::vector<std::string> words;
    if (!even) words = {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"};
    words.insert(words.end(), {"-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p"});
    return words;
}

/// How the file's ending asks for the frames to be encoded.
std::vector<std::string> encoding(const VideoJob& job) {
    std::string ending = std::filesystem::path(job.file).extension().string();
    for (char& c : ending) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (ending == ".webp") return {"-c:v", "libwebp", "-quality", "85", "-loop", "0"};
    if (ending == ".apng") return {"-c:v", "apng", "-plays", "0"};
    if (ending == ".gif")  // a palette of the frames' own colours
        return {"-filter_complex", "[0:v]split[a][b];[a]palettegen[p];[b][p]paletteuse", "-loop", "0"};
    return h264(job.even);
}

void check(const Ending& end, const std::string& what) {
    if (!end.good()) throw OutputError(what + ": ffmpeg failed, " + end.text());
}

}  // namespace

std::vector<std::string> ffmpeg_command(const VideoJob& job) {
    std::filesystem::path directory = job.directory.lexically_normal();
    if (!directory.has_filename()) directory = directory.parent_path();
    std::string pattern;
    for (const char c : directory.string()) pattern += c == '%' ? "%%" : std::string(1, c);
    pattern += "/%06d.png";
    const std::string name = directory.filename().string();
    char fps[32];
    std::snprintf(fps, sizeof fps, "%.10g", job.fps);
    std::vector<std::string> words = {"ffmpeg", "-framerate", fps};
    if (job.first > 0) words.insert(words.end(), {"-start_number", std::to_string(job.first)});
    words.insert(words.end(), {"-i", pattern, "-frames:v", std::to_string(job.count)});
    for (std::string& word : encoding(job)) words.push_back(std::move(word));
    words.push_back(!job.file.empty()                                   ? job.file
                    : name.empty() || name == "." || name == ".." ? "frames.mp4"
                                                                        : name + ".mp4");
    return words;
}

std::string command_line(const VideoJob& job) {
    std::string line;
    for (const std::string& word : ffmpeg_command(job)) line += (line.empty() ? "" : " ") + shell_quoted(word);
    return line;
}

bool run_ffmpeg(const VideoJob& job) {
    std::vector<std::string> words = ffmpeg_command(job);
    words.insert(words.begin() + 1, {"-y", "-loglevel", "error", "-nostdin"});
    try {
        const std::string file = words.back();
        check(Child("ffmpeg", std::move(words), {.in = open_null().get(), .out = STDERR_FILENO}).wait(), file);  // stdout belongs to results
    } catch (const StartError& problem) {
        if (problem.error == ENOENT) return false;
        throw;
    }
    return true;
}

VideoStream::VideoStream(double fps, bool even, int threads) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.10g", fps);
    std::vector<std::string> words = {"ffmpeg", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", rate, "-i", "pipe:0"};
    for (std::string& word : h264(even)) words.push_back(std::move(word));
    if (threads > 0) words.insert(words.end(), {"-threads", std::to_string(threads)});
    words.insert(words.end(), {"-frag_duration", "1000000", "-movflags", "empty_moov", "-f", "mp4", "pipe:1"});
    try {
        ffmpeg_ = std::make_unique<Child>("ffmpeg", std::move(words), Streams{.in = pipe_.read.get()});
    } catch (const StartError& problem) {
        if (problem.error != ENOENT) throw;
        throw OutputError("there is no ffmpeg here; install it (Debian: ffmpeg), or take the pictures");
    }
    pipe_.read.close();
}

void VideoStream::add(std::string_view png) {
    if (const int error = write_all(pipe_.write.get(), png))
        throw OutputError("ffmpeg's input cannot be written: " + std::generic_category().message(error));
}

void VideoStream::finish() {
    pipe_.write.close();
    check(ffmpeg_->wait(), "video");
}

}  // namespace tetfront
