#include "engine/scene/json_document.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>

namespace tetfront {

namespace {

using nlohmann::json;

constexpr std::size_t max_bytes = std::size_t{1} << 20;
constexpr std::size_t max_nesting = 32;

std::string cut(std::string text, std::size_t length) {
    if (text.size() <= length) return text;
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80) --length;  // not inside a character
    return text.substr(0, length) + "...";
}

/// Follows the parser through the document: knows the JSON pointer of the present position and each object's keys.
class Position {
 public:
    /// The callback of nlohmann::json::parse. Throws InputError for a repeated key and for too deep nesting.
    void on(json::parse_event_t event, const json& parsed, const std::string& source) {
        switch (event) {
            case json::parse_event_t::object_start:
            case json::parse_event_t::array_start:
                count_element();
                if (levels_.size() == max_nesting) {
                    throw InputError(source, pointer(), "is nested too deeply",
                                     "use at most " + std::to_string(max_nesting) + " levels");
                }
                levels_.push_back({event == json::parse_event_t::array_start, 0, {}, {}});
                break;
            case json::parse_event_t::key:
                levels_.back().key = parsed.get_ref<const std::string&>();
                if (!levels_.back().keys.insert(levels_.back().key).second) {
                    throw InputError(source, pointer(), "appears twice in the same object", "keep one of the two");
                }
                break;
            case json::parse_event_t::object_end:
            case json::parse_event_t::array_end:
                levels_.pop_back();
                break;
            case json::parse_event_t::value:
                count_element();
                break;
        }
    }

    void count_element() {
        if (!levels_.empty() && levels_.back().is_array) ++levels_.back().elements;
    }

    [[nodiscard]] std::string pointer() const {
        std::string result;
        for (const Level& level : levels_) {
            if (!level.is_array) {
                result = pointer_to(result, level.key);
            } else if (level.elements > 0) {
                result = pointer_to(result, level.elements - 1);
            }
        }
        return result;
    }

 private:
    struct Level {
        bool is_array;
        std::size_t elements;  // begun so far, of an array
        std::string key;       // the last one, of an object
        std::set<std::string> keys;
    };
    std::vector<Level> levels_;
};

InputError malformed(const json::parse_error& error, std::string_view text, const std::string& source) {
    const std::size_t offset = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    const std::string_view before = text.substr(0, offset);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t newline = before.rfind('\n');
    const std::size_t column = offset - (newline == std::string_view::npos ? 0 : newline + 1) + 1;
    // The library's text is "[...] parse error at line 3, column 5: syntax error while parsing ...".
    std::string detail = error.what();
    const std::size_t place = detail.find(", column ");
    if (const std::size_t colon = detail.find(": ", place == std::string::npos ? 0 : place);
        colon != std::string::npos) {
        detail.erase(0, colon + 2);
    }
    return {source, "line " + std::to_string(line) + ", column " + std::to_string(column),
            "is not JSON: " + one_line(detail, 200), "correct it there"};
}

/// Throws json::parse_error for malformed text, InputError for everything else that is refused.
json parse_strictly(std::string_view text, const std::string& source) {
    if (text.size() > max_bytes) throw InputError(source, "", "is larger than 1 MiB", "use a smaller scene file");
    Position position;
    try {
        return json::parse(text, [&](int, json::parse_event_t event, json& parsed) {
            position.on(event, parsed, source);
            return true;
        });
    } catch (const json::out_of_range&) {
        position.count_element();  // the number itself, which the parser did not report
        throw InputError(source, position.pointer(), "holds a number that is too large", "use a number below 1.8e308");
    }
}

std::vector<std::string> split_pointer(const std::string& pointer) {
    std::vector<std::string> keys;
    for (std::size_t i = 0; i < pointer.size(); ++i) {
        if (pointer[i] == '/') {
            keys.emplace_back();
        } else if (pointer[i] == '~' && i + 1 < pointer.size() && (pointer[i + 1] == '0' || pointer[i + 1] == '1')) {
            keys.back() += pointer[++i] == '0' ? '~' : '/';
        } else {
            keys.back() += pointer[i];
        }
    }
    return keys;
}

json override_value(const Override& entry, const std::string& source) {
    try {
        return parse_strictly(entry.second, source);
    } catch (const json::parse_error&) {
        json value = entry.second;
        try {
            static_cast<void>(value.dump());
        } catch (const json::type_error&) {
            throw InputError(source, "", "is neither JSON nor text in UTF-8", "correct the value");
        }
        return value;
    }
}

void apply(const Override& entry, json& root, const std::string& source) {
    const std::string who = source + ": override " + one_line(entry.first + '=' + entry.second, 80);
    if (entry.first.empty() || entry.first.front() != '/') {
        throw InputError(who, "", "does not name a value", "begin with a JSON pointer such as /front/tolerance");
    }
    const std::vector<std::string> keys = split_pointer(entry.first);
    if (keys.size() >= max_nesting) throw InputError(who, "", "is nested too deeply", "use a shorter pointer");
    json* node = &root;
    std::string pointer;
    for (const std::string& key : keys) {
        if (node->is_object()) {
            node = &(*node)[key];
            pointer = pointer_to(pointer, key);
            if (node->is_null() && &key != &keys.back()) *node = json::object();
        } else if (node->is_array()) {
            const bool number = !key.empty() && key.size() < 10 &&
                                std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
            if (!number || std::stoul(key) >= node->size()) {
                throw InputError(who, pointer_to(pointer, key), "is not there",
                                 node->empty() ? "the array is empty: give the whole array"
                                               : "use an index from 0 to " + std::to_string(node->size() - 1));
            }
            node = &(*node)[std::stoul(key)];
            pointer = pointer_to(pointer, key);
        } else {
            throw InputError(who, pointer, "is " + brief(*node) + " and has no \"" + one_line(key, 40) + "\" in it",
                             "override this value as a whole");
        }
    }
    *node = override_value(entry, who);
}

}  // namespace

std::string read_text_file(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        throw InputError(file.string(), "", "is a directory", "give the path of a scene file (.json)");
    }
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::string text(max_bytes + 1, '\0');
    if (stream) stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!stream.is_open() || stream.bad()) {
        throw InputError(file.string(), "", std::string("cannot be read: ") + std::strerror(errno ? errno : EIO),
                         "give the path of a scene file (.json)");
    }
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return text;
}

JsonDocument parse_document(std::string_view text, const std::string& source, const std::vector<Override>& overrides) {
    JsonDocument document{source, {}, overrides};
    try {
        document.root = parse_strictly(text, source);
    } catch (const json::parse_error& error) {
        throw malformed(error, text, source);
    }
    for (const Override& entry : overrides) apply(entry, document.root, source);
    return document;
}

std::string pointer_to(const std::string& parent, const std::string& key) {
    std::string token;
    for (char c : key) {
        if (c == '~') {
            token += "~0";
        } else if (c == '/') {
            token += "~1";
        } else {
            token += c;
        }
    }
    return parent + '/' + one_line(token, 60);
}

std::string pointer_to(const std::string& parent, std::size_t index) { return parent + '/' + std::to_string(index); }

std::string one_line(const std::string& text, std::size_t length) {
    const std::string quoted = json(text).dump(-1, ' ', false, json::error_handler_t::replace);
    std::string line;
    for (std::size_t i = 1; i + 1 < quoted.size(); ++i) {  // without JSON's quotes and what only they need
        if (quoted[i] == '\\' && (quoted[i + 1] == '"' || quoted[i + 1] == '\\')) ++i;
        line += quoted[i];
    }
    return cut(line, length);
}

std::string brief(const json& value) { return cut(value.dump(-1, ' ', false, json::error_handler_t::replace), 40); }

}  // namespace tetfront
