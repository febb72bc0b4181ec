#pragma once
// What a server keeps in files that clients may name: scenes to load, recordings, saved states. A name from a client is
// looked up in a listing of the folder and never becomes a path by itself, so nothing outside can be reached.
//
//     Library library("assets/scenes", "/var/lib/tetfront");
//     for (const auto& scene : library.scenes()) ... scene.name, scene.title
//     if (const auto file = library.scene_file("bunny")) Scene scene = load_scene(*file);

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

/// A name of a scene, a recording or a saved state, as clients may say it: 1..64 of A-Z a-z 0-9 - _ . and no dot in front.
bool is_plain_name(std::string_view text);

class Library {
 public:
    /// Either may be empty: no scenes, nothing is kept. `data` is made when it is first needed. Reads all scenes.
    Library(std::filesystem::path scenes, std::filesystem::path data);
    Library() = default;

    struct SceneEntry {
        std::string name, title;
    };
    /// Files NAME.json that are scenes, by name; others are left out. Reads those that have changed since the last time. Any thread.
    [[nodiscard]] std::vector<SceneEntry> scenes() const;
    [[nodiscard]] bool has_scenes() const { return !scenes_.empty(); }
    /// nullopt: there is no file NAME.json. Nothing is read, so it may be no scene.
    [[nodiscard]] std::optional<std::filesystem::path> scene_file(std::string_view name) const;

    struct FileEntry {
        std::string name;  // with the extension
        std::uint64_t bytes = 0;
        std::filesystem::path path;
    };
    [[nodiscard]] bool keeps() const { return !data_.empty(); }
    [[nodiscard]] std::vector<FileEntry> recordings() const { return files("recordings", ".tfr"); }
    [[nodiscard]] std::vector<FileEntry> states() const { return files("states", ".tfs"); }
    /// Where the small picture of a scene lies, if it has been made.
    [[nodiscard]] std::filesystem::path thumbnail(const std::string& scene) const { return data_ / "thumbnails" / (scene + ".png"); }
    /// Where a file of this plain name without extension is to be written. Throws OutputError when the folder cannot be made.
    [[nodiscard]] std::filesystem::path new_recording(const std::string& name) const { return place("recordings", name + ".tfr"); }
    [[nodiscard]] std::filesystem::path new_thumbnail(const std::string& scene) const { return place("thumbnails", scene + ".png"); }
    [[nodiscard]] std::filesystem::path new_state(const std::string& name) const { return place("states", name + ".tfs"); }

    /// What went wrong as clients are told: where the folders lie is nobody's business.
    [[nodiscard]] std::string without_folders(std::string text) const;

 private:
    [[nodiscard]] std::vector<FileEntry> files(const char* folder, std::string_view extension) const;
    [[nodiscard]] std::filesystem::path place(const char* folder, const std::string& file) const;

    struct Title {
        std::filesystem::file_time_type changed;
        std::uintmax_t bytes = 0;
        std::optional<std::string> text;  // none: the file is no scene
    };
    struct Titles {
        std::mutex mutex;
        std::map<std::string, Title> known;  // by name; guarded by mutex
    };

    std::filesystem::path scenes_, data_;
    std::shared_ptr<Titles> titles_ = std::make_shared<Titles>();  // of all copies
};

/// The entry of this name, or nullopt.
std::optional<Library::FileEntry> find(const std::vector<Library::FileEntry>& files, std::string_view name);

/// $XDG_DATA_HOME/tetfront or ~/.local/share/tetfront; empty when neither is known.
std::filesystem::path default_data_directory();

}  // namespace tetfront
