#pragma once
// A program that a test runs, with its output.
//
//     ChildProcess serve({program_path(), "serve", "--port", "0"});
//     std::string url = serve.read_line();      // of stdout
//     serve.signal(SIGTERM);
//     EXPECT_EQ(serve.wait().status, 0);

#include <array>
#include <csignal>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace tetfront {

class ChildProcess {
 public:
    struct Result {
        int status = -1;  // exit status; -signal when a signal ended it
        std::string out, err;
    };

    /// `out`: file for stdout instead of the pipe.
    explicit ChildProcess(std::vector<std::string> command, const char* out = nullptr) {
        std::array<int, 2> out_pipe{}, err_pipe{};
        if (::pipe2(out_pipe.data(), O_CLOEXEC) || ::pipe2(err_pipe.data(), O_CLOEXEC))
            throw std::runtime_error("pipe");
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        if (out)
            posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out, O_WRONLY, 0);
        else
            posix_spawn_file_actions_adddup2(&actions, out_pipe[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, err_pipe[1], STDERR_FILENO);
        std::vector<char*> arguments;
        for (std::string& argument : command) arguments.push_back(argument.data());
        arguments.push_back(nullptr);
        const int error = posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        ::close(out_pipe[1]);
        ::close(err_pipe[1]);
        out_ = out_pipe[0];
        err_ = err_pipe[0];
        if (error) throw std::runtime_error("cannot run " + command[0]);
    }
    ~ChildProcess() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, nullptr, 0);
        }
        ::close(out_);
        ::close(err_);
    }
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Next line of stdout without its end; "" at the end.
    std::string read_line() {
        std::string line;
        for (char c = 0; ::read(out_, &c, 1) == 1 && c != '\n';) line += c;
        return line;
    }
    void signal(int number) const { ::kill(pid_, number); }
    [[nodiscard]] pid_t pid() const { return pid_; }
    /// The rest of its output, once it has ended. Its stderr must fit into a pipe (64 KiB).
    Result wait() {
        Result result;
        result.out = read_all(out_);
        result.err = read_all(err_);
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = -1;
        result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        return result;
    }

 private:
    static std::string read_all(int descriptor) {
        std::string all;
        std::array<char, 4096> part{};
        for (ssize_t n = 0; (n = ::read(descriptor, part.data(), part.size())) > 0;)
            all.append(part.data(), static_cast<std::size_t>(n));
        return all;
    }

    pid_t pid_ = -1;
    int out_ = -1, err_ = -1;
};

}  // namespace tetfront
