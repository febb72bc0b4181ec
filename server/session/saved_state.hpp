#pragma once
// A moment of a session as a file: what commands have set beyond the scene, one line of JSON, then the simulation's snapshot.
//
//     write_saved_state(file, {.scene = "bunny", .time = 1.5, .order = 2, .edits = edits, .snapshot = stage->save_state()});
//     SavedState state = read_saved_state(file);

#include "engine/simulation/edits.hpp"
#include "server/session/command.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace tetfront {

struct SavedState {
    std::string scene;  // its name
    double time = 0;    // [s]
    int order = 2;
    std::optional<command::Levels> levels = {};  // none: the scene's
    Edits edits;
    std::string snapshot;  // as Simulation::snapshot() has it
};

/// Whole or not at all. Throws OutputError.
void write_saved_state(const std::filesystem::path& file, const SavedState& state);
/// Throws InputError. What the edits and the snapshot hold is for the simulation to check.
SavedState read_saved_state(const std::filesystem::path& file);
/// The same without the snapshot, which is nearly all of the file.
SavedState read_saved_head(const std::filesystem::path& file);

}  // namespace tetfront
