#pragma once
// What a client may ask of a running simulation, as plain data: already checked for types and ranges that need no
// model.
//
//     session.submit(client, command::Gravity{{0, 0, -1.62}}, [](const std::optional<CommandError>& error) { ... });

#include "engine/base/types.hpp"
#include "engine/simulation/simulation.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

namespace tetfront {

using ClientId = std::uint32_t;

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
// Persistent forces: they belong to the session, and outlive the client that set them.
struct ForceAdd {             ///< replaces the force of this number
    std::uint32_t force = 0;  // below 2^31
    SurfacePoint point;
    Vec3 value;  // [N]
};
struct ForceMove {
    std::uint32_t force = 0;
    std::optional<SurfacePoint> point;  // none: where it is
    Vec3 value;                         // [N]
};
struct ForceRemove {
    std::uint32_t force = 0;
};
struct Pin {  ///< what is within `radius` of this point at rest stays where it is, or becomes free
    bool pinned = true;
    SurfacePoint point;
    double radius = 0;  // [m]
};
struct StiffnessScale {
    double value = 1;  // 0.01..100
    struct Part {      ///< what is within `radius` of this point at rest
        SurfacePoint point;
        double radius = 0;  // [m]
    };
    std::optional<Part> part;  // none: everywhere
};
struct Damping {  ///< Rayleigh damping on top of the materials' own
    double mass = 0;       // 0..1000 1/s
    double stiffness = 0;  // 0..10 s
};
struct Order {
    int value = 2;  // 1 or 2
};
struct Levels {  ///< of active tets; a deeper one than the tree and the order have is the deepest that they have
    int min = 0;
    int max = 99;  // min..99
};
struct Load {
    std::string scene;  // a name of the library
};
struct Save {
    std::string name;
};
struct Restore {
    std::string name;
};
struct RecordStart {
    std::string name;  // empty: made from the scene's name and the date
    double fps = 30;   // 1..240 frames per simulated second
    Field field = Field::none;
};
struct RecordStop {};

// These the server answers by itself; a session refuses them.
struct Colouring {
    Field field = Field::none;  // that this client's frames come with
};
struct Compression {
    bool on = false;  // of this client's frames
};
struct Token {
    std::string value;
};
struct Acknowledge {            // has no id and no answer
    std::uint32_t frame = 0;  // sequence number of the newest frame that was shown
};
struct Scenes {};
struct States {};
struct Recordings {};
}  // namespace command

using Command =
    std::variant<command::Play, command::Pause, command::Reset, command::Step, command::Speed, command::PullBegin,
                 command::PullMove, command::PullEnd, command::Gravity, command::Tolerance, command::Budget,
                 command::Seek, command::ForceAdd, command::ForceMove, command::ForceRemove, command::Pin,
                 command::StiffnessScale, command::Damping, command::Order, command::Levels, command::Load, command::Save,
                 command::Restore, command::RecordStart, command::RecordStop, command::Colouring, command::Compression, command::Token,
                 command::Acknowledge, command::Scenes, command::States, command::Recordings>;

/// Why a command changed nothing. `code` is one of the codes in server/PROTOCOL.md.
struct CommandError {
    std::string code;
    std::string pointer;  // JSON pointer into the command; empty: the whole command
    std::string message;  // one line
    friend bool operator==(const CommandError&, const CommandError&) = default;
};

}  // namespace tetfront
