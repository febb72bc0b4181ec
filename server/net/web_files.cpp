#include "server/net/web_files.hpp"

#include "engine/base/error.hpp"

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace tetfront {

namespace {

constexpr std::size_t max_total_bytes = std::size_t{64} << 20;

constexpr std::array<std::pair<std::string_view, std::string_view>, 13> content_types = {{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".wasm", "application/wasm"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".map", "application/json"},
    {".txt", "text/plain; charset=utf-8"},
}};

std::string_view content_type_of(const std::filesystem::path& file) {
    for (const auto& [extension, type] : content_types)
        if (file.extension() == extension) return type;
    return {};
}

std::string etag_of(std::string_view bytes) {
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
    for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    std::array<char, 19> text{};
    std::snprintf(text.data(), text.size(), "\"%016llx\"", static_cast<unsigned long long>(hash));
    return text.data();
}

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in) throw InputError(file.string(), "", "cannot be read", "");
    return bytes;
}

}  // namespace

WebFiles load_web_files(const std::filesystem::path& folder) {
    WebFiles files;
    std::size_t total = 0;
    std::error_code error;
    std::filesystem::recursive_directory_iterator entry(folder, error), end;
    for (; !error && entry != end; entry.increment(error)) {
        const std::string_view type = content_type_of(entry->path());
        if (!entry->is_regular_file() || type.empty()) continue;
        WebFile file;
        file.bytes = read(entry->path());
        total += file.bytes.size();
        if (total > max_total_bytes)
            throw InputError(folder.string(), "", "holds more than 64 MiB", "give the folder of the built web client");
        file.content_type = type;
        file.etag = etag_of(file.bytes);
        const std::string target = "/" + entry->path().lexically_relative(folder).generic_string();
        // The build puts a hash of the content into the names of everything below assets/.
        file.cache_control = target == "/index.html"          ? "no-store"
                             : target.starts_with("/assets/") ? "public, max-age=31536000, immutable"
                                                              : "no-cache";
        files.emplace(target, std::move(file));
    }
    const auto index = files.find("/index.html");
    if (index == files.end())
        throw InputError(folder.string(), "", "holds no built web client (index.html)",
                         "build it with `npm run build` in web/, or give its folder with --web");
    files.emplace("/", index->second);
    return files;
}

const WebFile* find(const WebFiles& files, std::string_view target) {
    const auto file = files.find(target.substr(0, target.find('?')));
    return file == files.end() ? nullptr : &file->second;
}

}  // namespace tetfront
