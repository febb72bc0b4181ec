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

int serve(const ServeOptions& options) {
    Scene scene = options.scene.load();
    WebFiles files = load_web_files(options.web);
    Session session(std::move(scene), !options.paused, options.scene.cache());
    Server server(options.server, std::move(files), session);
    if (options.server.host != "127.0.0.1" && options.server.host != "localhost" && options.server.host != "::1")
        spdlog::warn("anyone who reaches {} can watch and pull: there is no password", options.server.host);
    std::cout << server.url() << std::endl;  // the only line on stdout: scripts read it
    server.run();
    return exit_ok;
}

}  // namespace

void add_serve(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("serve", "Simulates live and serves it to browsers");
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
