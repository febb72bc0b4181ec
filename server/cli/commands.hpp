#pragma once
// The subcommands of the `tetfront` program, one file each. Each adds itself to the parser; main runs the chosen one.
//
//     void add_info(CLI::App& program, Action& action) {
//         CLI::App* command = program.add_subcommand("info", "...");
//         auto options = std::make_shared<Options>();
//         command->add_option("scene", options->scene)->required();
//         command->callback([options, &action] { action = [options] { return info(*options); }; });
//     }

#include "engine/base/atomic_file.hpp"
#include "engine/mechanics/elasticity_cache.hpp"
#include "engine/scene/scene.hpp"
#include "server/base/exit_status.hpp"

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tetfront {

/// Does the work and returns an ExitStatus; throws InputError, OutputError or PortTaken.
using Action = std::function<int()>;

void add_serve(CLI::App& program, Action& action);
void add_render(CLI::App& program, Action& action);
void add_record(CLI::App& program, Action& action);
void add_run(CLI::App& program, Action& action);
void add_study(CLI::App& program, Action& action);
void add_info(CLI::App& program, Action& action);
void add_import(CLI::App& program, Action& action);
void add_paper(CLI::App& program, Action& action);
void add_bench(CLI::App& program, Action& action);

/// A scene file, values that replace the file's, and where what is computed from it is kept.
struct SceneArguments {
    std::string file;
    std::vector<std::string> settings;  // "path=value"
    std::string cache_directory;        // empty: none

    /// Adds the positional SCENE, --set, --cache and --no-cache to a subcommand. `fallback`: used when no file is given;
    /// empty: required.
    void add_to(CLI::App& command, const std::string& fallback = "");
    [[nodiscard]] Scene load() const;
    /// For build_model; warnings go to the log.
    [[nodiscard]] CacheSettings cache() const;
};

/// Throws InputError when writing to `output` would replace `input`.
void check_not_same(const std::string& output, const std::string& input);

/// "front.tolerance=0.01" or "/front/tolerance=0.01" -> {"/front/tolerance", "0.01"}. A value that is not JSON is a
/// string: view.colouring=stiffness. Throws InputError for text without `=` or path.
Override parse_setting(const std::string& setting);

}  // namespace tetfront
