#pragma once
// Where the project and its program are. The paths are compiled into one file only, so that all other files compile to
// the same object code wherever the project stands and a compiler cache serves every checkout.
//
//     const Scene scene = load_scene(source_folder() / "assets/scenes/box.json");
//     ChildProcess serve({program_path(), "serve", "--port", "0"});

#include <filesystem>
#include <string>

namespace tetfront {

/// The checkout that this was built from.
std::filesystem::path source_folder();
/// The `tetfront` program of this build; empty when it was built without the server.
std::string program_path();

}  // namespace tetfront
