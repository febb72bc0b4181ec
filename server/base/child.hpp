#pragma once
// A process that this one starts and waits for.
//
//     Pipe out = make_pipe();
//     Child child("ffmpeg", {"ffmpeg", "-i", file, "pipe:1"}, {.out = out.write.get()});
//     out.write.close();                       // or reading never ends
//     ... read(out.read.get(), ...)
//     if (const Ending end = child.wait(); !end.good()) throw OutputError("ffmpeg failed, " + end.text());

#include "engine/base/atomic_file.hpp"
#include "server/base/descriptor.hpp"

#include <string>
#include <vector>

namespace tetfront {

/// Nothing was started. error: its number, ENOENT when there is no such program.
struct StartError : OutputError {
    StartError(const std::string& program, int error);
    int error;
};

/// How a process has ended.
struct Ending {
    int status = -1;  // that it exited with; -1: it did not
    int signal = 0;   // that ended it instead; 0: none, or it is not known
    [[nodiscard]] bool good() const { return status == 0; }
    [[nodiscard]] std::string text() const;  // "exit status 2", "signal 9"
};

/// Descriptors that become a child's standard streams. It has no others of this program.
struct Streams {
    int in = 0, out = 1, err = 2;
};

class Child {
 public:
    /// program: a file, or without a slash a name that is looked for in PATH. words: its name first. Throws StartError.
    Child(const std::string& program, std::vector<std::string> words, const Streams& streams = {});
    /// Kills it, unless it has been waited for.
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    [[nodiscard]] int process() const { return process_; }  // -1: it has been waited for
    /// Nothing after wait().
    void signal(int number) const;
    /// Once.
    Ending wait();

 private:
    int process_ = -1;
};

}  // namespace tetfront
