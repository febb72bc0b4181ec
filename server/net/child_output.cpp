#include "server/net/child_output.hpp"

#include <cerrno>
#include <utility>

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace tetfront {

namespace {

constexpr int nicer = 10;
constexpr std::size_t longest_line = 4096;

/// The last line that is not empty.
std::string last_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    const std::size_t begin = text.find_last_of("\r\n");
    return begin == std::string::npos ? text : text.substr(begin + 1);
}

std::vector<std::string> with_name(std::vector<std::string> words) {
    words.insert(words.begin(), "tetfront");
    return words;
}

}  // namespace

std::string& child_program() {
    static std::string program = "/proc/self/exe";
    return program;
}

ChildOutput::Parts::Parts(std::vector<std::string> words)
    : child(child_program(), with_name(std::move(words)), {.in = open_null().get(), .out = out.write.get(), .err = said.get()}),
      ended(static_cast<int>(::syscall(SYS_pidfd_open, child.process(), 0))) {  // Debian 12's header for it is for C only
    if (ended.get() < 0) throw StartError(child_program(), errno);
    out.write.close();
    static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(child.process()), ::getpriority(PRIO_PROCESS, 0) + nicer));
}

ChildOutput::End ChildOutput::Parts::end() {
    const Ending how = child.wait();
    if (how.good()) return {how, ""};
    const std::string line = last_line(read_end(said.get(), longest_line));
    return {how, line.empty() ? "ended with " + how.text() : line};
}

}  // namespace tetfront
