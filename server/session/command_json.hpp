#pragma once
// Commands as JSON, as clients send them (server/PROTOCOL.md): for recordings, which keep what was done to a simulation.
//
//     if (auto json = recorded_json(client, command)) recording.add(RecordedEvent{time, *json});

#include "server/session/command.hpp"

#include <optional>
#include <string>

namespace tetfront {

/// One line without an id; a pull also has "client", as numbers of different clients may be the same. nullopt: the command
/// does not change what is simulated (such as pause or save) or ends the recording (such as load).
std::optional<std::string> recorded_json(ClientId client, const Command& command);

}  // namespace tetfront
