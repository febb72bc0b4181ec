#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_lines.hpp"
#include "server/net/access.hpp"
#include "server/net/server.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include <spdlog/sinks/sink.h>
#include <spdlog/spdlog.h>

namespace tetfront {

namespace {

struct ServeOptions {
    SceneArguments scene;
    Server::Options server{.signals = true};
    std::string web = TETFRONT_WEB_DIR;
    std::string scenes, data = default_data_directory().string();
    std::string token_file;
    std::uint64_t recording_megabytes = 1024;
    std::size_t files = Session::Settings{}.files, tets = Session::Settings{}.tets;
    int stall_seconds = 10, idle_seconds = 20;
    std::string log_level = "info", log_format = "text";
    bool paused = false;
};

/// The folder of scenes that may be loaded: that of the first scene when none is given.
std::filesystem::path scene_folder(const ServeOptions& options) {
    if (!options.scenes.empty()) return options.scenes;
    return is_recording(options.scene.file) ? std::filesystem::path() : std::filesystem::absolute(options.scene.file).parent_path();
}

std::unique_ptr<Session> make_session(const ServeOptions& options) {
    Session::Settings settings{.cache = options.scene.cache(),
                               .library = Library(scene_folder(options), options.data),
                               .recording_bytes = options.recording_megabytes << 20,
                               .files = options.files,
                               .tets = options.tets};
    if (!is_recording(options.scene.file))
        return std::make_unique<Session>(options.scene.load(), !options.paused, std::move(settings));
    if (!options.scene.settings.empty())
        throw InputError("--set", options.scene.settings[0], "cannot change a recording", "use it with a scene");
    Recording recording(options.scene.file);
    if (!recording.complete())
        spdlog::warn("{} was cut short; its {} whole frames are shown", options.scene.file, recording.frame_count());
    return std::make_unique<Session>(std::move(recording), !options.paused, std::move(settings));
}

/// Log lines as text for people, or as JSON objects for programs.
void set_up_log(const ServeOptions& options) {
    spdlog::set_level(spdlog::level::from_str(options.log_level));
    if (options.log_format == "json") spdlog::default_logger()->sinks()[0]->set_formatter(std::make_unique<JsonLines>());
}

int serve(ServeOptions options) {
    set_up_log(options);
    options.server.token = read_token(options.token_file);
    options.server.patience = std::chrono::seconds(2);
    options.server.limits.stall = std::chrono::seconds(options.stall_seconds);
    options.server.idle_timeout = std::chrono::seconds(options.idle_seconds);
    const std::unique_ptr<Session> session = make_session(options);
    WebFiles files = load_web_files(options.web);
    Server server(options.server, std::move(files), *session);
    std::cout << server.url() << std::endl;  // the only line on stdout: scripts read it
    try {
        server.run();
    } catch (const StillBusy& busy) {
        // In the middle of meshing, say, which cannot be interrupted. Nothing is lost: connections are closed, files are
        // written whole or, recordings, frame by frame. Whoever stops a server should not have to wait or kill it.
        spdlog::warn("{}; ending without it", busy.what());
        spdlog::shutdown();
        std::_Exit(exit_ok);
    }
    return exit_ok;
}

}  // namespace

void add_serve(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("serve", "Serves a live simulation, or a recording, to browsers");
    const auto options = std::make_shared<ServeOptions>();
    Limits& limits = options->server.limits;
    options->scene.add_to(*command, TETFRONT_DEFAULT_SCENE);
    command->add_option("--host", options->server.host, "Address to listen on; beyond the loopback a token is needed")->capture_default_str();
    command->add_option("--port", options->server.port, "Port to listen on; 0: any free one")->capture_default_str();
    command->add_option("--web", options->web, "Folder of the built web client")
        ->capture_default_str()
        ->type_name("DIR");
    command->add_flag("--paused", options->paused, "Starts paused");
    command->add_option("--scenes", options->scenes, "Folder of scenes that clients may load; default: that of SCENE")->type_name("DIR");
    command->add_option("--data", options->data, "Keeps recordings here; empty: nowhere")->capture_default_str()->type_name("DIR");
    command->add_option("--token-file", options->token_file, "Its first line is the token that clients must know; or TETFRONT_TOKEN")
        ->type_name("FILE");
    command->add_option("--allow-host", options->server.names, "A further name of this server, as in a proxy's address; repeatable")
        ->type_name("NAME[:PORT]")
        ->allow_extra_args(false);
    const auto whole = [](const char* low_and_up) { return CLI::Range(1, 1'000'000'000).description(low_and_up); };
    command->add_option("--max-connections", limits.connections, "Connections of any kind")->capture_default_str()->check(whole("1.."));
    command->add_option("--max-clients", limits.clients, "Clients that watch")->capture_default_str()->check(whole("1.."));
    command->add_option("--max-per-address", limits.connections_per_address, "Connections of one address")
        ->capture_default_str()
        ->check(whole("1.."));
    command->add_option("--max-message-rate", limits.messages_per_second, "Messages a second of one client")
        ->capture_default_str()
        ->check(CLI::Range(1, 1'000'000));
    command->add_option("--max-message-bytes", limits.message_bytes, "Bytes of one message of a client")
        ->capture_default_str()
        ->check(CLI::Range(1024, 1024 * 1024));
    command->add_option("--max-recording", options->recording_megabytes, "MiB of one recording")->capture_default_str()->check(whole("1.."));
    command->add_option("--max-files", options->files, "Recordings that are kept, and saved states")->capture_default_str()->check(whole("1.."));
    command->add_option("--max-tets", options->tets, "Smallest tets of a scene that clients load")->capture_default_str()->check(whole("1.."));
    command->add_option("--stall-seconds", options->stall_seconds, "/healthz answers 503 when one step takes longer")
        ->capture_default_str()
        ->check(CLI::Range(1, 86'400));
    command->add_option("--idle-seconds", options->idle_seconds, "A client that is silent for so long is gone; half of it: pinged")
        ->capture_default_str()
        ->check(CLI::Range(1, 3600));
    command->add_option("--log-level", options->log_level, "What is logged to stderr")
        ->capture_default_str()
        ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}));
    command->add_option("--log-format", options->log_format, "text, or json: an object a line")
        ->capture_default_str()
        ->check(CLI::IsMember({"text", "json"}));
    command->callback([options, &action] { action = [options] { return serve(*options); }; });
}

}  // namespace tetfront
