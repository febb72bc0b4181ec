#pragma once
// Another process of this program, whose output is read without waiting for it: it draws what would hold up the thread
// that serves, and a crash or a lack of memory there ends nothing here. The simulation goes first: it is nicer than this one.
//
//     ChildOutput child(executor, {"render", "run.tfr", "--stdout", "zip"});
//     child.read(buffer, [](Error error, std::size_t size) { ... });    // again and again, until it fails
//     child.wait([](ChildOutput::End end) { ... });

#include "server/base/child.hpp"

#include <csignal>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/posix/stream_descriptor.hpp>

namespace tetfront {

/// The program that children run, /proc/self/exe; tests, which are another program, set it.
std::string& child_program();

class ChildOutput {
 public:
    /// words: after the program's name. Throws OutputError.
    template <class Executor>
    ChildOutput(const Executor& executor, std::vector<std::string> words)
        : parts_(std::move(words)), out_(executor, parts_.out.read.release()), ended_(executor, parts_.ended.release()) {}

    template <class Handler>
    void read(boost::asio::mutable_buffer buffer, Handler handler) {
        out_.async_read_some(buffer, std::move(handler));
    }
    /// A read that is outstanding fails.
    void stop() {
        boost::system::error_code ignored;  // it ends by itself then
        out_.cancel(ignored);
        parts_.child.signal(SIGKILL);
    }
    struct End {
        Ending how;
        std::string problem;  // empty: it ended well; otherwise one line: what it wrote to stderr last, or how it ended
    };
    /// After the end of its output, which may be earlier than its own. This must live until `handler` is called.
    template <class Handler>
    void wait(Handler handler) {
        ended_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                          [this, handler = std::move(handler)](boost::system::error_code) mutable { handler(parts_.end()); });
    }

 private:
    struct Parts {
        explicit Parts(std::vector<std::string> words);
        End end();

        Pipe out = make_pipe();
        Descriptor said = make_buffer();  // its stderr: not a pipe, which would have to be read as well
        Child child;
        Descriptor ended;  // can be read when it has
    };
    Parts parts_;
    boost::asio::posix::stream_descriptor out_, ended_;
};

}  // namespace tetfront
