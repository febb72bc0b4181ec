#pragma once
// What can be downloaded of a recording beside the file itself: all its pictures in a zip file, or a video.
//
//     if (is_export(path)) ... find_export(library, "/recordings/run.tfr/frames.zip", "w=640&h=360")->words

#include "server/session/library.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

struct Export {
    std::vector<std::string> words;  // of the command that writes it to stdout
    std::string content_type, file;  // what it is called on the client's disk
};

/// Whether the path of a request has the form /recordings/NAME/frames.zip or /recordings/NAME/video.mp4.
bool is_export(std::string_view path);

/// path: as above; query: as of /snapshot.png, of which w, h and view count. nullopt: there is no such recording. Throws
/// InputError for a query that is not understood.
std::optional<Export> find_export(const Library& library, std::string_view path, std::string_view query);

/// Whether videos can be made: there is an ffmpeg in PATH.
bool has_ffmpeg();

}  // namespace tetfront
