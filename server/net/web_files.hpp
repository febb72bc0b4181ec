#pragma once
// The built web client, read once at start: a request is answered from this map or not at all, so nothing that a client
// sends ever reaches the file system.
//
//     WebFiles files = load_web_files("web/dist");
//     const WebFile* page = find(files, "/");

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace tetfront {

struct WebFile {
    std::string bytes;
    std::string content_type;
    std::string etag;  // quoted, a hash of the bytes
    std::string cache_control;
};

using WebFiles = std::map<std::string, WebFile, std::less<>>;  // by request target, e.g. "/assets/main-a1b2.js"

/// All files of known types below `folder`; "/" is index.html. Throws InputError when there is no index.html, a file
/// cannot be read, or there are more than 64 MiB.
WebFiles load_web_files(const std::filesystem::path& folder);

/// target: of an HTTP request; a query is ignored. nullptr: no such file.
const WebFile* find(const WebFiles& files, std::string_view target);

}  // namespace tetfront
