#pragma once
// From a client's text to a Command: everything that can be checked without the model is checked here.
//
//     ParsedCommand parsed = parse_command(R"({"id": 7, "command": "speed", "value": 2})");
//     if (const auto* error = std::get_if<CommandError>(&parsed.result)) ...
//
// Safe against hostile text of any length: nesting is cut off early, and nothing recurses.

#include "server/session/command.hpp"

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace tetfront {

struct ParsedCommand {
    std::optional<std::int64_t> id;  // nullopt: could not be read, or an acknowledgement
    std::variant<Command, CommandError> result;
};

/// Never throws for any text. Error codes: malformed, unknown_command, unknown_key, missing_key, wrong_type,
/// out_of_range; see server/PROTOCOL.md.
ParsedCommand parse_command(std::string_view text);

}  // namespace tetfront
