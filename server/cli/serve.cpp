#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"
#include "server/net/server.hpp"

#include <iostream>
#include <memory>

#include <spdlog/spdlog.h>

namespace tetfront {

namespace {

struct ServeOptions {
    SceneArguments scene;
    Server::Options server{.signals = true};
    std::string web = TETFRONT_WEB_DIR;
    bool paused = false;
};

std::unique_ptr<Session> make_session(const ServeOptions& options) {
    if (!is_recording(options.scene.file)) return std::make_unique<Session>(options.scene.load(), !options.paused, options.scene.cache());
    if (!options.scene.settings.empty())
        throw InputError("--set", options.scene.settings[0], "cannot change a recording", "use it with a scene");
    Recording recording(options.scene.file);
    if (!recording.complete())
        spdlog::warn("{} was cut short; its {} whole frames are shown", options.scene.file, recording.frame_count());
    return std::make_unique<Session>(std::move(recording), !options.paused);
}

int serve(const ServeOptions& options) {
    const std::unique_ptr<Session> session = make_session(options);
    WebFiles files = load_web_files(options.web);
    Server server(options.server, std::move(files), *session);
    if (options.server.host != "127.0.0.1" && options.server.host != "localhost" && options.server.host != "::1")
        spdlog::warn("anyone who reaches {} can watch and pull: there is no password", options.server.host);
    std::cout << server.url() << std::endl;  // the only line on stdout: scripts read it
    server.run();
    return exit_ok;
}

}  // namespace

void add_serve(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("serve", "Serves a live simulation, or a recording, to browsers");
    const auto options = std::make_shared<ServeOptions>();
    options->scene.add_to(*command, TETFRONT_DEFAULT_SCENE);
    command->add_option("--host", options->server.host, "Address to listen on")->capture_default_str();
    command->add_option("--port", options->server.port, "Port to listen on; 0: any free one")->capture_default_str();
    command->add_option("--web", options->web, "Folder of the built web client")
        ->capture_default_str()
        ->type_name("DIR");
    command->add_flag("--paused", options->paused, "Starts paused");
    command->callback([options, &action] { action = [options] { return serve(*options); }; });
}

}  // namespace tetfront
