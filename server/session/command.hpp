#pragma once
// What a client may ask of a running simulation, as plain data: already checked for types and ranges that need no
// model.
//
//     session.submit(client, command::Gravity{{0, 0, -1.62}}, [](const std::optional<CommandError>& error) { ... });

#include "engine/base/types.hpp"
#include "engine/simulation/simulation.hpp"

#include <cstdint>
#include <string>
#include <variant>

namespace tetfront {

namespace command {
struct Play {};
struct Pause {};
struct Reset {};    ///< to rest; ends all pulls; what plays goes on playing
struct Step {       ///< refused while playing
    int count = 1;  // 1..1000
};
struct Speed {
    double value = 1;  // 0.01..10 simulated seconds per real second
};
struct PullBegin {           ///< a pull that goes on is grabbed anew
    std::uint32_t pull = 0;  // the client's own number, below 2^31
    SurfacePoint point;
    Vec3 target;  // [m]
};
struct PullMove {
    std::uint32_t pull = 0;
    Vec3 target;  // [m]
};
struct PullEnd {
    std::uint32_t pull = 0;
};
struct Gravity {
    Vec3 value;  // [m/s^2]
};
struct Tolerance {
    double value = 0;  // 1e-6..1
};
struct Budget {               ///< per step; replaces the scene's
    int tets = 1 << 28;       // 1..2^28
    double milliseconds = 0;  // 0..1e6; 0: no limit
};
struct Seek {         ///< to another moment of a recording; a simulation refuses
    double time = 0;  // [s] >= 0
};
}  // namespace command

using Command =
    std::variant<command::Play, command::Pause, command::Reset, command::Step, command::Speed, command::PullBegin,
                 command::PullMove, command::PullEnd, command::Gravity, command::Tolerance, command::Budget,
                 command::Seek>;

/// Why a command changed nothing. `code` is one of the codes in server/PROTOCOL.md.
struct CommandError {
    std::string code;
    std::string pointer;  // JSON pointer into the command; empty: the whole command
    std::string message;  // one line
    friend bool operator==(const CommandError&, const CommandError&) = default;
};

}  // namespace tetfront
