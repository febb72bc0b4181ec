#include "server/session/library.hpp"

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "engine/scene/scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace tetfront {

namespace {

/// Calls use(path, name without extension) for each regular file of a plain name, in the order of the names.
template <class Use>
void each_file(const std::filesystem::path& folder, std::string_view extension, const Use& use) {
    std::vector<std::filesystem::path> paths;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code unknown;
        if (entry->path().extension() == extension && is_plain_name(entry->path().filename().string()) && entry->is_regular_file(unknown))
            paths.push_back(entry->path());
    }
    std::ranges::sort(paths);
    for (const auto& path : paths) use(path, path.stem().string());
}

/// Any JSON file may lie in the folder; one that is no scene cannot be loaded, so it is not offered.
std::optional<std::string> title_of(const std::filesystem::path& file, const std::string& name) {
    try {
        const Scene scene = load_scene(file);
        return scene.title.empty() ? name : scene.title;
    } catch (const InputError&) {
        return std::nullopt;
    }
}

}  // namespace

bool is_plain_name(std::string_view text) {
    const auto plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
    };
    return !text.empty() && text.size() <= 64 && text.front() != '.' && std::ranges::all_of(text, plain);
}

Library::Library(std::filesystem::path scenes, std::filesystem::path data) : scenes_(std::move(scenes)), data_(std::move(data)) {
    static_cast<void>(this->scenes());  // now, or the first client that asks holds up the others
}

std::vector<Library::SceneEntry> Library::scenes() const {
    std::vector<SceneEntry> result;
    if (scenes_.empty()) return result;
    const std::lock_guard lock(titles_->mutex);
    std::map<std::string, Title> known;
    each_file(scenes_, ".json", [&](const auto& path, const std::string& name) {
        std::error_code gone;
        const auto changed = std::filesystem::last_write_time(path, gone);
        const std::uintmax_t bytes = gone ? 0 : std::filesystem::file_size(path, gone);
        if (gone) return;
        const auto before = titles_->known.find(name);
        const bool same = before != titles_->known.end() && before->second.changed == changed && before->second.bytes == bytes;
        const Title& title = known[name] = same ? before->second : Title{changed, bytes, title_of(path, name)};
        if (title.text) result.push_back({name, *title.text});
    });
    titles_->known = std::move(known);
    return result;
}

std::optional<std::filesystem::path> Library::scene_file(std::string_view name) const {
    std::optional<std::filesystem::path> file;
    if (!scenes_.empty())
        each_file(scenes_, ".json", [&](const auto& path, const std::string& known) {
            if (known == name) file = path;
        });
    return file;
}

std::string Library::without_folders(std::string text) const {
    const auto erase = [&text](const std::filesystem::path& folder) {
        const std::string start = folder.string() + "/";
        for (std::size_t at = 0; (at = text.find(start)) != std::string::npos;) text.erase(at, start.size());
    };
    if (!data_.empty()) {  // first, as it may lie in the folder of scenes
        for (const char* folder : {"recordings", "states", "thumbnails"}) erase(data_ / folder);
        erase(data_);
    }
    if (!scenes_.empty()) erase(scenes_);
    return text;
}

std::vector<Library::FileEntry> Library::files(const char* folder, std::string_view extension) const {
    std::vector<FileEntry> result;
    if (data_.empty()) return result;
    each_file(data_ / folder, extension, [&](const auto& path, const std::string&) {
        std::error_code error;
        const std::uintmax_t size = std::filesystem::file_size(path, error);
        if (!error) result.push_back({path.filename().string(), size, path});
    });
    return result;
}

std::filesystem::path Library::place(const char* folder, const std::string& file) const {
    ENSURE(keeps() && is_plain_name(file), file);
    std::error_code error;
    std::filesystem::create_directories(data_ / folder, error);
    if (error) throw OutputError((data_ / folder).string() + ": cannot be made: " + error.message());
    return data_ / folder / file;
}

std::optional<Library::FileEntry> find(const std::vector<Library::FileEntry>& files, std::string_view name) {
    const auto entry = std::ranges::find(files, name, &Library::FileEntry::name);
    return entry == files.end() ? std::nullopt : std::optional(*entry);
}

std::filesystem::path default_data_directory() {
    if (const char* data = std::getenv("XDG_DATA_HOME"); data && data[0] == '/') return std::filesystem::path(data) / "tetfront";
    if (const char* home = std::getenv("HOME"); home && *home) return std::filesystem::path(home) / ".local/share/tetfront";
    return {};
}

}  // namespace tetfront
