#pragma once
// What the server says, as bytes: server/PROTOCOL.md in code. Knows no sockets.
//
//     std::string model = encode_model(*frame->model, generation);
//     std::string topology = encode_topology(*frame, generation);
//     std::string moment = encode_frame(*frame, generation, sequence);
//     std::string text = state_event(state, viewers);

#include "engine/simulation/frame.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/net/outbox.hpp"
#include "server/session/library.hpp"
#include "server/session/session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

inline constexpr int protocol_version = 1;
inline constexpr std::string_view subprotocol = "tetfront.v1";

// Binary messages. generation: number of the model, from 1. The topology's epoch is the frame's.
std::string encode_model(const FrameModel& model, std::uint16_t generation);
/// surface_count and front_count are those of the frames of this topology.
std::string encode_topology(const FrameTopology& topology, std::size_t front_count, std::uint16_t generation);
/// Positions are quantised to 16 bits against the box around all positions of this frame; a coordinate that is not
/// finite becomes the box's low end.
/// A frame that has values of a field becomes a coloured one.
std::string encode_frame(const Frame& frame, std::uint16_t generation, std::uint32_t sequence);

// JSON messages, one line each, valid UTF-8 whatever the input.
struct HelloLimits {
    std::size_t message_bytes = 64 * 1024;
    int messages_per_second = 1000;
    std::uint64_t recording_bytes = 0;
};
std::string hello_event(const SessionModel& model, const SessionState& state, std::uint16_t generation, const HelloLimits& limits,
                        const std::vector<std::string_view>& capabilities);
std::string state_event(const SessionState& state, std::size_t viewers);
std::string settings_event(const SessionState& state);
std::string recording_event(const RecordingStatus& recording);
std::string link_event(const Outbox::Statistics& link);
std::string log_event(std::string_view level, std::string_view message);
/// remaining: [s], when it can be said.
std::string progress_event(std::string_view what, double fraction, const std::optional<double>& remaining);
std::string ok_reply(std::int64_t id);
std::string scenes_reply(std::int64_t id, const std::vector<Library::SceneEntry>& scenes);
std::string states_reply(std::int64_t id, const std::vector<Library::FileEntry>& states);
std::string recordings_reply(std::int64_t id, const std::vector<Library::FileEntry>& recordings, bool video);
std::string error_reply(std::optional<std::int64_t> id, const CommandError& error);

}  // namespace tetfront
