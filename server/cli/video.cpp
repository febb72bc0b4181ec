#include "server/cli/video.hpp"

#include "engine/base/atomic_file.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

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

/// An exit status of waitpid() that is not success.
[[noreturn]] void fail(const std::string& what, int status) {
    throw OutputError(what + ": ffmpeg failed, " +
                      (WIFEXITED(status) ? "exit status " + std::to_string(WEXITSTATUS(status)) : "signal " + std::to_string(WTERMSIG(status))));
}

std::vector<char*> pointers(std::vector<std::string>& words) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    return arguments;
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    return status;
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
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);  // stdout belongs to results
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, "ffmpeg", &actions, nullptr, pointers(words).data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (error == ENOENT) return false;
    if (error) throw OutputError("ffmpeg cannot be run: " + std::generic_category().message(error));
    if (const int status = wait_for(child)) fail(words.back(), status);
    return true;
}

VideoStream::VideoStream(double fps, bool even) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.10g", fps);
    std::vector<std::string> words = {"ffmpeg", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", rate, "-i", "pipe:0"};
    for (std::string& word : h264(even)) words.push_back(std::move(word));
    words.insert(words.end(), {"-frag_duration", "1000000", "-movflags", "empty_moov", "-f", "mp4", "pipe:1"});
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw OutputError("ffmpeg cannot be run: " + std::generic_category().message(errno));
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
    const int error = ::posix_spawnp(&child_, "ffmpeg", &actions, nullptr, pointers(words).data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(ends[0]);
    pipe_ = ends[1];
    if (error) {
        ::close(pipe_);
        throw OutputError(error == ENOENT ? "there is no ffmpeg here; install it (Debian: ffmpeg), or take the pictures"
                                          : "ffmpeg cannot be run: " + std::generic_category().message(error));
    }
}

VideoStream::~VideoStream() {
    if (pipe_ >= 0) ::close(pipe_);
    if (child_ > 0) ::kill(child_, SIGKILL), wait_for(child_);
}

void VideoStream::add(std::string_view png) { write_all(pipe_, png, "ffmpeg's input"); }

void VideoStream::finish() {
    ::close(std::exchange(pipe_, -1));
    if (const int status = wait_for(std::exchange(child_, -1))) fail("video", status);
}

void write_all(int descriptor, std::string_view bytes, const char* what) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throw OutputError(std::string(what) + " cannot be written: " + std::generic_category().message(errno));
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

}  // namespace tetfront
