#pragma once
// Head of a report: what made it, where and when, so that anyone can make it again.
//
//     write_head(out, "Speed against error", "build/release/tests/accuracy_report");

#include <cstdio>
#include <ctime>
#include <fstream>
#include <ostream>
#include <string>
#include <thread>

namespace tetfront {

inline std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown CPU";
}

/// Title, then the command, date and machine.
inline void write_head(std::ostream& out, const std::string& title, const std::string& command) {
    const std::time_t now = std::time(nullptr);
    char date[32];
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    out << "# " << title << "\n\nMade by `" << command << "` on " << date << ", " << cpu_name() << ", "
        << std::thread::hardware_concurrency() << " threads. Do not edit: run the command again.\n";
}

inline std::string format_number(double value, const char* format = "%.3g") {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

}  // namespace tetfront
