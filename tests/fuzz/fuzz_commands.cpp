#include "server/net/command_parser.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

/// Any text gives a command or a refusal of one line, and no command holds a number that is not finite.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tetfront;
    const ParsedCommand parsed = parse_command({reinterpret_cast<const char*>(data), size});
    if (const auto* error = std::get_if<CommandError>(&parsed.result)) {
        if (error->code.empty() || error->message.find('\n') != std::string::npos) std::abort();
        return 0;
    }
    const Command& command = std::get<Command>(parsed.result);
    if (const auto* pull = std::get_if<command::PullBegin>(&command))
        if (!pull->target.allFinite() || !pull->point.barycentric.allFinite()) std::abort();
    if (const auto* force = std::get_if<command::ForceAdd>(&command))
        if (!force->value.allFinite() || !force->point.barycentric.allFinite()) std::abort();
    if (const auto* gravity = std::get_if<command::Gravity>(&command))
        if (!gravity->value.allFinite()) std::abort();
    if (const auto* speed = std::get_if<command::Speed>(&command))
        if (!(speed->value >= 0.01 && speed->value <= 10)) std::abort();
    return 0;
}
