#include "server/net/exports.hpp"

#include "server/net/snapshot.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <unistd.h>

namespace tetfront {

namespace {

struct Kind {
    std::string_view ending, format, content_type;
};
constexpr std::array<Kind, 2> kinds = {{{"/frames.zip", "zip", "application/zip"}, {"/video.mp4", "mp4", "video/mp4"}}};
constexpr std::string_view folder = "/recordings/";

const Kind* kind_of(std::string_view path) {
    const auto kind = std::ranges::find_if(kinds, [&](const Kind& k) { return path.ends_with(k.ending); });
    return path.starts_with(folder) && kind != kinds.end() && path.size() > folder.size() + kind->ending.size() ? &*kind : nullptr;
}

}  // namespace

bool is_export(std::string_view path) { return kind_of(path) != nullptr; }

std::optional<Export> find_export(const Library& library, std::string_view path, std::string_view query) {
    const Kind* const kind = kind_of(path);
    if (!kind) return std::nullopt;
    const std::string_view name = path.substr(folder.size(), path.size() - folder.size() - kind->ending.size());
    const auto recording = find(library.recordings(), name);
    if (!recording) return std::nullopt;
    const SnapshotQuery wanted = parse_snapshot_query(query, {});
    Export result{.words = {"render", recording->path.string(), "--stdout", std::string(kind->format), "--size",
                            std::to_string(wanted.width) + "x" + std::to_string(wanted.height),
                            "--threads", "1", "--command", "tetfront render " + recording->path.filename().string()},
                  .content_type = std::string(kind->content_type),
                  .file = recording->path.stem().string() + "." + std::string(kind->format)};
    if (!wanted.view_text.empty()) {
        // As JSON, whatever stands before it: text that does not begin with a brace would be a file's name.
        result.words.insert(result.words.end(), {"--view", wanted.view_text.substr(wanted.view_text.find('{'))});
        if (!parse_view(wanted.view_text, "view").keyframes.empty()) result.words.insert(result.words.end(), {"--camera", "keyframes"});
    }
    return result;
}

bool has_ffmpeg() {
    const char* const variable = std::getenv("PATH");
    std::string_view path = variable ? variable : "/usr/local/bin:/usr/bin:/bin";
    while (!path.empty()) {
        const std::string_view directory = path.substr(0, path.find(':'));
        path.remove_prefix(std::min(path.size(), directory.size() + 1));
        if (!directory.empty() && ::access((std::string(directory) + "/ffmpeg").c_str(), X_OK) == 0) return true;
    }
    return false;
}

}  // namespace tetfront
