#include "server/base/child.hpp"

#include "engine/base/error.hpp"

#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace tetfront {

StartError::StartError(const std::string& program, int error_)
    : OutputError(program + " cannot be run: " + std::generic_category().message(error_)), error(error_) {}

std::string Ending::text() const {
    if (status >= 0) return "exit status " + std::to_string(status);
    return signal > 0 ? "signal " + std::to_string(signal) : "an unknown status";
}

Child::Child(const std::string& program, std::vector<std::string> words, const Streams& streams) {
    std::signal(SIGCHLD, SIG_DFL);  // whoever started this program may have ignored it; then the system forgets how children end
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, streams.in, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, streams.out, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, streams.err, STDERR_FILENO);
    // Libraries open what is not close-on-exec: a child that had a server's sockets would keep connections and the port open.
    ::posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    const int error = ::posix_spawnp(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (!error) return;
    process_ = -1;
    throw StartError(program, error);
}

Child::~Child() {
    signal(SIGKILL);
    if (process_ > 0) wait();
}

void Child::signal(int number) const {
    if (process_ > 0) ::kill(process_, number);
}

Ending Child::wait() {
    ENSURE(process_ > 0, "a process is waited for twice");
    const int process = std::exchange(process_, -1);
    int status = 0, waited = 0;
    while ((waited = ::waitpid(process, &status, 0)) < 0 && errno == EINTR) {}
    if (waited < 0) return {};
    return WIFEXITED(status) ? Ending{.status = WEXITSTATUS(status)} : Ending{.signal = WTERMSIG(status)};
}

}  // namespace tetfront
