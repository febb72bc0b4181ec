#include "server/cli/json_lines.hpp"

#include <chrono>
#include <ctime>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

namespace tetfront {

void JsonLines::format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) {
    using namespace std::chrono;
    const auto since = duration_cast<milliseconds>(message.time.time_since_epoch()).count();
    const std::time_t seconds = since / 1000;
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    char date[32];
    const std::size_t length = std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &utc);
    const auto level = spdlog::level::to_string_view(message.level);
    const nlohmann::ordered_json object = {
        {"time", fmt::format("{}.{:03}Z", std::string_view(date, length), since % 1000)},
        {"level", std::string_view(level.data(), level.size())},
        {"message", std::string_view(message.payload.data(), message.payload.size())}};
    const std::string text = object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
    line.append(text.data(), text.data() + text.size());
}

}  // namespace tetfront
