#include "server/net/child_output.hpp"

#include "engine/base/atomic_file.hpp"

#include <system_error>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace tetfront {

namespace {

/// The last line that is not empty.
std::string last_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    const std::size_t begin = text.find_last_of("\r\n");
    return begin == std::string::npos ? text : text.substr(begin + 1);
}

}  // namespace

std::string& child_program() {
    static std::string program = "/proc/self/exe";
    return program;
}

ChildPipes start_child(const std::string& program, std::vector<std::string> words) {
    const auto fail = [](int error) { throw OutputError("a process cannot be started: " + std::generic_category().message(error)); };
    words.insert(words.begin(), "tetfront");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::array<int, 2> out{}, err{};
    if (::pipe2(out.data(), O_CLOEXEC) != 0) fail(errno);
    if (::pipe2(err.data(), O_CLOEXEC) != 0) {
        const int error = errno;
        ::close(out[0]), ::close(out[1]);
        fail(error);
    }
    ::fcntl(err[0], F_SETFL, O_NONBLOCK);  // a grandchild may keep it open
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
    // The library's sockets are not close-on-exec: a child that had them would keep connections and the port open.
    ::posix_spawn_file_actions_addclosefrom_np(&actions, 3);
    ChildPipes child{-1, out[0], err[0]};
    const int error = ::posix_spawn(&child.process, program.c_str(), &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(out[1]), ::close(err[1]);
    if (error) {
        ::close(out[0]), ::close(err[0]);
        fail(error);
    }
    return child;
}

std::string end_child(const ChildPipes& child, bool kill) {
    if (kill) ::kill(child.process, SIGKILL);
    int status = 0;
    while (::waitpid(child.process, &status, 0) < 0 && errno == EINTR) {}
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = ::read(child.err, part.data(), part.size())) > 0;) said.append(part.data(), static_cast<std::size_t>(n));
    ::close(child.err);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
    const std::string line = last_line(said);
    if (!line.empty()) return line;
    return WIFEXITED(status) ? "ended with status " + std::to_string(WEXITSTATUS(status)) : "was ended by signal " + std::to_string(WTERMSIG(status));
}

}  // namespace tetfront
