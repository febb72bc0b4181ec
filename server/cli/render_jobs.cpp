#include "server/cli/render_jobs.hpp"

#include "server/base/child.hpp"
#include "server/base/exit_status.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>
#include <poll.h>
#include <unistd.h>

namespace tetfront {

namespace {

/// One process and the pipe on which it reports its frames as JSON lines. Should this program die, the pipe breaks and
/// the job ends with its next frame.
class Job {
 public:
    explicit Job(std::vector<std::string> words) : child_("/proc/self/exe", std::move(words), {.out = events_.write.get()}) {
        events_.write.close();
    }
    ~Job() {
        child_.signal(SIGTERM);  // not SIGKILL: it removes the file that it is at
        if (child_.process() > 0) child_.wait();
    }
    Job(const Job&) = delete;
    Job& operator=(const Job&) = delete;

    [[nodiscard]] int descriptor() const { return events_.read.get(); }
    void stop() const { child_.signal(SIGINT); }
    /// Takes what is there; false: the job has ended.
    template <class Use>
    bool take(const Use& use) {
        std::array<char, 4096> part{};
        const ssize_t size = ::read(events_.read.get(), part.data(), part.size());
        if (size < 0 && errno == EINTR) return true;
        if (size <= 0) return false;
        text_.append(part.data(), static_cast<std::size_t>(size));
        for (std::size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1)) {
            const auto event = nlohmann::json::parse(text_.substr(0, end), nullptr, false);
            if (event.is_object() && event.value("event", "") == "frame") use(event.value("frame", 0));
        }
        return true;
    }
    /// Its exit status, or as a shell has it for a signal.
    int wait() {
        const Ending end = child_.wait();
        return end.status >= 0 ? end.status : 128 + end.signal;
    }

 private:
    Pipe events_ = make_pipe();
    Child child_;
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
        words.insert(words.end(), {"--json", "--threads", std::to_string(std::max(1, processors / jobs)), "--frames",
                                   std::to_string(numbers[begin]) + "-" + std::to_string(numbers[end - 1])});
        running.push_back(std::make_unique<Job>(std::move(words)));
    }
    int result = exit_ok;
    while (!running.empty()) {
        std::vector<pollfd> waiting;
        for (const auto& job : running) waiting.push_back({job->descriptor(), POLLIN, 0});
        if (::poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR)
            throw OutputError("waiting for render processes: " + std::generic_category().message(errno));
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
