#pragma once
// Log lines as JSON objects, one a line: {"time":"2026-01-31T23:59:59.123Z","level":"warning","message":"..."}
//
//     logger->sinks()[0]->set_formatter(std::make_unique<JsonLines>());

#include <memory>

#include <spdlog/formatter.h>

namespace tetfront {

class JsonLines : public spdlog::formatter {
 public:
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override;
    [[nodiscard]] std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JsonLines>(); }
};

}  // namespace tetfront
