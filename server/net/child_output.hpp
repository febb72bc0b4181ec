#pragma once
// Another process of this program, whose output is read without waiting for it: it draws what would hold up the thread
// that serves, and a crash or a lack of memory there ends nothing here.
//
//     ChildOutput child(executor, {"render", "run.tfr", "--stdout", "zip"});
//     child.read(buffer, [](Error error, std::size_t size) { ... });    // again and again, until it fails
//     std::string problem = child.wait();

#include <array>
#include <cerrno>
#include <csignal>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/posix/stream_descriptor.hpp>

namespace tetfront {

/// The descriptors of a process that runs.
struct ChildPipes {
    int process = -1, out = -1, err = -1;
};
/// program: its file. Throws OutputError.
ChildPipes start_child(const std::string& program, std::vector<std::string> words);
/// Kills it if `kill` says so. Empty when it ended well; otherwise one line: what it wrote to stderr last, or its status.
std::string end_child(const ChildPipes& child, bool kill);

/// The program that children run, /proc/self/exe; tests, which are another program, set it.
std::string& child_program();

class ChildOutput {
 public:
    /// words: after the program's name. Throws OutputError.
    template <class Executor>
    ChildOutput(const Executor& executor, std::vector<std::string> words)
        : child_(start_child(child_program(), std::move(words))), out_(executor, child_.out) {}
    ~ChildOutput() {
        if (child_.process > 0) end_child(child_, true);
    }
    ChildOutput(const ChildOutput&) = delete;
    ChildOutput& operator=(const ChildOutput&) = delete;

    template <class Handler>
    void read(boost::asio::mutable_buffer buffer, Handler handler) {
        out_.async_read_some(buffer, std::move(handler));
    }
    /// A read that is outstanding fails.
    void stop() {
        boost::system::error_code ignored;  // it ends by itself then
        out_.cancel(ignored);
        if (child_.process > 0) ::kill(child_.process, SIGKILL);
    }
    /// After the end of its output. As end_child().
    std::string wait() { return end_child(std::exchange(child_, {}), false); }

 private:
    ChildPipes child_;
    boost::asio::posix::stream_descriptor out_;  // owns child_.out
};

}  // namespace tetfront
