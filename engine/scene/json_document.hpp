#pragma once
// From bytes to a JSON tree, strictly: what a scene file (or an override) may not be is refused here, before anybody
// looks at its meaning.
//
//     JsonDocument document = parse_document(read_text_file(file), file.string(), {{"/front/tolerance", "0.01"}});
//
// Refused with an InputError: more than 1 MiB, more than 32 levels of nesting, malformed JSON (with line and column), a
// key twice in one object, a number too large for a double, an override whose pointer leads nowhere.

#include "engine/scene/override.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace tetfront {

struct JsonDocument {
    std::string source;               // name for errors
    nlohmann::json root;              // overrides applied
    std::vector<Override> overrides;  // what was applied, so that an error can name it
};

/// Throws InputError when `file` cannot be read, is a directory or is too large.
std::string read_text_file(const std::filesystem::path& file);

/// An override's value is JSON or, when it is not, a string. It replaces or adds one value; objects on the way to it
/// are made when missing, array elements must exist.
JsonDocument parse_document(std::string_view text, const std::string& source, const std::vector<Override>& overrides);

/// "/parent/key" with the escapes of RFC 6901, fit for one line of an error message.
std::string pointer_to(const std::string& parent, const std::string& key);
std::string pointer_to(const std::string& parent, std::size_t index);

/// For error messages: any text on one line of UTF-8 (control characters as in JSON: \n, \u0001), cut to `length`
/// bytes.
std::string one_line(const std::string& text, std::size_t length);
/// For error messages: JSON text of a value, cut to 40 bytes.
std::string brief(const nlohmann::json& value);

}  // namespace tetfront
