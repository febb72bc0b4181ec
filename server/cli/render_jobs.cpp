#include "server/cli/render_jobs.hpp"

#include "server/cli/commands.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace tetfront {

namespace {

[[noreturn]] void fail(const std::string& what, int error) {
    throw OutputError(what + ": " + std::generic_category().message(error));
}

/// One process and the pipe on which it reports its frames as JSON lines. Should this program die, the pipe breaks and
/// the job ends with its next frame.
class Job {
 public:
    Job(std::vector<std::string> words, int threads) {
        std::array<int, 2> pipe{};
        if (::pipe2(pipe.data(), O_CLOEXEC) != 0) fail("a render process cannot be started", errno);
        events_ = pipe[0];
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
        std::vector<char*> arguments, environment;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        // The rasteriser's threads of all jobs together are as many as there are processors.
        std::string rasteriser = "LP_NUM_THREADS=" + std::to_string(threads);
        for (char** variable = environ; *variable; ++variable)
            if (std::strncmp(*variable, "LP_NUM_THREADS=", 15) != 0) environment.push_back(*variable);
        environment.push_back(rasteriser.data());
        environment.push_back(nullptr);
        const int error = ::posix_spawn(&process_, "/proc/self/exe", &actions, nullptr, arguments.data(), environment.data());
        ::posix_spawn_file_actions_destroy(&actions);
        ::close(pipe[1]);
        if (error) fail("a render process cannot be started", error);
    }
    ~Job() {
        if (process_ > 0) {
            ::kill(process_, SIGTERM);
            wait();
        }
        ::close(events_);
    }
    Job(const Job&) = delete;
    Job& operator=(const Job&) = delete;

    [[nodiscard]] int descriptor() const { return events_; }
    void stop() const {
        if (process_ > 0) ::kill(process_, SIGINT);
    }
    /// Takes what is there; false: the job has ended.
    template <class Use>
    bool take(const Use& use) {
        std::array<char, 4096> part{};
        const ssize_t size = ::read(events_, part.data(), part.size());
        if (size < 0 && errno == EINTR) return true;
        if (size <= 0) return false;
        text_.append(part.data(), static_cast<std::size_t>(size));
        for (std::size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1)) {
            const auto event = nlohmann::json::parse(text_.substr(0, end), nullptr, false);
            if (event.is_object() && event.value("event", "") == "frame") use(event.value("frame", 0));
        }
        return true;
    }
    int wait() {
        int status = 0;
        while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {}
        process_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

 private:
    pid_t process_ = -1;
    int events_ = -1;
    std::string text_;
};

}  // namespace

int run_jobs(const std::vector<std::string>& arguments, const std::vector<int>& numbers, int jobs,
             const std::function<void(int)>& frame) {
    const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    std::vector<std::unique_ptr<Job>> running;
    for (int j = 0; j < jobs; ++j) {
        const std::size_t begin = numbers.size() * static_cast<std::size_t>(j) / static_cast<std::size_t>(jobs);
        const std::size_t end = numbers.size() * static_cast<std::size_t>(j + 1) / static_cast<std::size_t>(jobs);
        if (begin == end) continue;
        std::vector<std::string> words = {"tetfront"};
        words.insert(words.end(), arguments.begin(), arguments.end());
        const int threads = std::max(1, processors / jobs);
        words.insert(words.end(), {"--json", "--threads", std::to_string(threads), "--frames",
                                   std::to_string(numbers[begin]) + "-" + std::to_string(numbers[end - 1])});
        running.push_back(std::make_unique<Job>(words, threads));
    }
    int result = exit_ok;
    while (!running.empty()) {
        std::vector<pollfd> waiting;
        for (const auto& job : running) waiting.push_back({job->descriptor(), POLLIN, 0});
        if (::poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) fail("waiting for render processes", errno);
        for (std::size_t i = waiting.size(); i-- > 0;) {
            if (waiting[i].revents == 0 || running[i]->take(frame)) continue;
            const int status = running[i]->wait();
            running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
            if (status == exit_ok || result != exit_ok) continue;
            result = status;
            for (const auto& job : running) job->stop();
        }
    }
    return result;
}

}  // namespace tetfront
