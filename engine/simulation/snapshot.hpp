#pragma once
// The complete mutable state of a Simulation as bytes: what was saved goes on to the bit as if it had never been
// interrupted, in the same Simulation or in a fresh one of the same model.
//
//     save_snapshot("run.state", simulation);          // whole or not at all, also when the machine loses power
//     load_snapshot("run.state", fresh_simulation);    // InputError, and nothing changed, when it does not fit
//
// A file begins with a magic number, the format's version, the hash of the model that it belongs to and a checksum. Bytes are
// in the machine's order. Nothing in them is believed: every number is held against its range and against the model
// before anything changes.
//
// What follows from the rest is not stored: hanging vertices' rows, matrices, indicators, what the timeline has released.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/types.hpp"
#include "engine/scene/scene.hpp"
#include "engine/simulation/simulation.hpp"

namespace tetfront {

/// As in the file: no padding, no pointers.
struct Snapshot {
    std::uint64_t model = 0;  // model_hash()
    std::string scene;        // its name, for messages
    std::uint64_t steps = 0;
    double time = 0;  // [s]

    // Settings, which commands and the timeline change.
    std::array<double, 3> gravity{};    // [m/s^2]
    double tolerance = 0;               // (0, 1]
    std::uint64_t budget_tets = 0;      // >= 1
    double budget_milliseconds = 0;     // 0: none
    double milliseconds_per_tet = 0;    // measured lately; 0 without a budget of time, which alone it steers

    std::vector<TetId> active;                   // of the front, ascending
    /// [vertices of the front] x [m], v [m/s], a [m/s^2], x and v of the step before
    std::vector<std::array<double, 15>> motion;
    std::uint8_t has_earlier = 0;                // 0 or 1: the last two of them count
    struct Pull {
        std::uint64_t id;
        std::int64_t leaf;
        std::array<double, 4> barycentric;
        std::array<double, 3> target;            // [m]
    };
    std::vector<Pull> pulls;                     // ascending ids

    // What adaptivity remembers.
    double reference_energy = 0;                        // [J]
    std::vector<std::array<std::uint64_t, 2>> rests;    // tet, step until which it rests; ascending tets

    // Of the last step, for the next frame's status.
    std::int32_t solver_iterations = 0;
    std::uint8_t converged = 1, rejected = 0;           // 0 or 1
    std::string warning;
};

/// Of all that steers steps and cannot be changed by commands: mesh, materials, pins, forces, timeline, solver, and the front's
/// order and levels; also what a scene sets at the start (gravity, tolerance, budget). Not of names, views and file names.
/// Cost: the tree.
std::uint64_t model_hash(const Model& model, const FrontSpec& front);

std::string encode(const Snapshot& snapshot);
/// Throws InputError when the bytes are no snapshot, of another version or damaged, or a number is out of every model's
/// range. name: of the file, for messages.
Snapshot decode(std::string_view bytes, const std::string& name);

/// Throws OutputError.
void save_snapshot(const std::filesystem::path& file, const Simulation& simulation);
/// Returns the number of steps made. Throws InputError, and changes nothing then.
std::uint64_t load_snapshot(const std::filesystem::path& file, Simulation& simulation);

}  // namespace tetfront
