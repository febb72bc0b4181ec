#pragma once
// `tetfront serve` as a process of its own on a free port, for what only a process shows: signals, memory, limits of the
// system.
//
//     ServerProcess server({scene, "--idle-seconds", "1"});
//     socket.connect({loopback, server.port()});
//     server.signal(SIGTERM);
//     EXPECT_EQ(server.wait().status, 0);

#include "tests/support/child_process.hpp"
#include "tests/support/project.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetfront {

class ServerProcess : public ChildProcess {
 public:
    /// arguments: of `tetfront serve`. most_blocks: of 512 bytes, the largest file that it may write; 0: no limit.
    explicit ServerProcess(const std::vector<std::string>& arguments, int most_blocks = 0)
        : ChildProcess(command(arguments, most_blocks)) {
        const std::string url = read_line();
        const std::size_t colon = url.rfind(':');
        if (colon == std::string::npos || colon < 5) throw std::runtime_error("tetfront serve did not start: " + wait().err);
        port_ = static_cast<unsigned short>(std::stoi(url.substr(colon + 1)));
    }

    [[nodiscard]] unsigned short port() const { return port_; }
    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port_); }

    [[nodiscard]] double resident_megabytes() const {
        std::ifstream statm("/proc/" + std::to_string(pid()) + "/statm");
        double all = 0, resident = 0;
        statm >> all >> resident;
        return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
    }
    [[nodiscard]] long descriptors() const {
        const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid()) + "/fd");
        return std::distance(begin(files), end(files));
    }
    [[nodiscard]] long threads() const {
        const std::filesystem::directory_iterator tasks("/proc/" + std::to_string(pid()) + "/task");
        return std::distance(begin(tasks), end(tasks));
    }

 private:
    static std::vector<std::string> command(const std::vector<std::string>& arguments, int most_blocks) {
        std::vector<std::string> words;
        if (most_blocks > 0) words = {"/bin/sh", "-c", "ulimit -f " + std::to_string(most_blocks) + "; exec \"$0\" \"$@\""};
        words.insert(words.end(), {program_path(), "serve", "--port", "0", "--log-level", "error"});
        words.insert(words.end(), arguments.begin(), arguments.end());
        return words;
    }

    unsigned short port_ = 0;
};

}  // namespace tetfront
