#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

namespace tetfront {

void SceneArguments::add_to(CLI::App& command, const std::string& fallback) {
    CLI::Option* scene = command.add_option("scene", file, "Scene file (JSON)")->type_name("SCENE");
    if (fallback.empty())
        scene->required();
    else
        file = fallback, scene->capture_default_str();
    command.add_option("--set", settings, "Replaces a value of the scene, e.g. --set front.tolerance=0.01; repeatable")
        ->type_name("PATH=VALUE")
        ->allow_extra_args(false);
    cache_directory = default_cache_directory().string();
    CLI::Option* cache = command
                             .add_option("--cache", cache_directory,
                                         "Keeps elasticity matrices here for the next start; an old file may be deleted")
                             ->type_name("DIR")
                             ->capture_default_str();
    command.add_flag_callback("--no-cache", [this] { cache_directory.clear(); }, "Computes them anew and keeps nothing")
        ->excludes(cache);
}

CacheSettings SceneArguments::cache() const {
    return {.directory = cache_directory, .warn = [](const std::string& line) { spdlog::warn("{}", line); }};
}

Scene SceneArguments::load() const {
    std::vector<Override> overrides;
    for (const std::string& setting : settings) overrides.push_back(parse_setting(setting));
    return load_scene(file, overrides);
}

Override parse_setting(const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == 0 || equals == std::string::npos)
        throw InputError("--set", setting, "is not of the form PATH=VALUE",
                         "write for example --set front.tolerance=0.01");
    std::string path = setting.substr(0, equals), value = setting.substr(equals + 1);
    if (!path.starts_with('/')) {
        std::ranges::replace(path, '.', '/');
        path.insert(path.begin(), '/');
    }
    if (!nlohmann::json::accept(value))
        value = nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return {path, value};
}

}  // namespace tetfront
