#include "engine/scene/json_reader.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace tetfront {

namespace {

std::string number_text(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", x);
    return text;
}

std::string list(const std::vector<std::string_view>& words) {
    std::string text;
    for (std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
    return text;
}

/// Levenshtein distance: insertions, deletions and replacements from a to b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

/// The key that was probably meant, or empty.
std::string_view nearest(std::string_view unknown, const std::vector<std::string_view>& keys) {
    if (unknown.size() > 40) return {};
    std::string_view best;
    std::size_t best_distance = std::max<std::size_t>(2, unknown.size() / 3) + 1;
    for (std::string_view key : keys) {
        const std::size_t distance = edit_distance(unknown, key);
        if (distance < best_distance && distance < key.size()) {
            best = key;
            best_distance = distance;
        }
    }
    return best;
}

/// Is `inner` the value at `outer` or inside of it?
bool lies_in(std::string_view inner, std::string_view outer) {
    return inner.substr(0, outer.size()) == outer && (inner.size() == outer.size() || inner[outer.size()] == '/');
}

}  // namespace

std::string Range::text() const {
    return (low_open ? '(' : '[') + number_text(low) + ", " + number_text(high) + (high_open ? ')' : ']');
}

void JsonValue::fail(const std::string& problem, const std::string& remedy) const {
    std::string whose;
    for (const auto& [pointer, text] : document_->overrides) {
        if (lies_in(pointer_, pointer) || lies_in(pointer, pointer_)) {
            whose += " (override " + one_line(pointer + '=' + text, 80) + ")";
        }
    }
    throw InputError(document_->source, pointer_.empty() ? "/" : pointer_, problem + whose, remedy);
}

double JsonValue::number(const Range& range) const {
    if (json_->is_number()) {
        const double value = json_->get<double>();
        if (range.contains(value)) return value;
    }
    fail("is " + text(), "use a number in " + range.text());
}

int JsonValue::integer(int low, int high) const {
    if (json_->is_number()) {
        const double value = json_->get<double>();
        if (value >= low && value <= high && value == std::floor(value)) return static_cast<int>(value);
    }
    fail("is " + text(), low == high ? "use " + std::to_string(low)
                                     : "use an integer in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
}

bool JsonValue::boolean() const {
    if (!json_->is_boolean()) fail("is " + text(), "use true or false");
    return json_->get<bool>();
}

std::string JsonValue::line(std::size_t max_characters) const {
    const std::string* line = string();
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    const auto begins_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };  // in UTF-8
    if (!line || line->empty() || std::any_of(line->begin(), line->end(), is_control) ||
        std::count_if(line->begin(), line->end(), begins_character) > static_cast<std::ptrdiff_t>(max_characters)) {
        fail("is " + text(), "use a string of one line and of 1 to " + std::to_string(max_characters) + " characters");
    }
    return *line;
}

Vec3 JsonValue::vector(const Range& each) const {
    const std::vector<JsonValue> parts = array(3);
    return {parts[0].number(each), parts[1].number(each), parts[2].number(each)};
}

std::vector<JsonValue> JsonValue::array() const {
    if (!json_->is_array()) fail("is " + text(), "use an array");
    std::vector<JsonValue> elements;
    for (std::size_t i = 0; i < json_->size(); ++i) {
        elements.push_back(JsonValue(document_, &(*json_)[i], pointer_to(pointer_, i)));
    }
    return elements;
}

std::vector<JsonValue> JsonValue::array(std::size_t size) const {
    if (!json_->is_array() || json_->size() != size) {
        fail("is " + text(), "use an array of " + std::to_string(size) + " values");
    }
    return array();
}

std::optional<JsonValue> JsonValue::member(std::string_view key) const {
    const auto found = json_->find(key);
    if (found == json_->end()) return std::nullopt;
    return JsonValue(document_, &*found, pointer_to(pointer_, std::string(key)));
}

JsonObject JsonValue::object(std::initializer_list<std::string_view> keys) const { return {*this, keys}; }

std::pair<std::string, JsonValue> JsonValue::one_of(std::initializer_list<std::string_view> keys) const {
    const JsonObject choice = object(keys);
    if (json_->size() != 1) fail("is " + text(), "use an object with exactly one of the keys " + list(keys));
    const std::string& key = json_->begin().key();
    return {key, choice.required(key)};
}

const std::string* JsonValue::string() const { return json_->get_ptr<const std::string*>(); }

JsonObject::JsonObject(JsonValue value, std::initializer_list<std::string_view> keys)
    : value_(std::move(value)), keys_(keys) {
    if (!value_.json_->is_object()) value_.fail("is " + value_.text(), "use an object with the keys " + list(keys_));
    for (const auto& [key, ignored] : value_.json_->items()) {
        if (std::find(keys_.begin(), keys_.end(), key) != keys_.end()) continue;
        const std::string_view meant = nearest(key, keys_);
        const JsonValue unknown(value_.document_, value_.json_, pointer_to(value_.pointer_, key));
        unknown.fail("is not a known key" + (meant.empty() ? "" : " (did you mean \"" + std::string(meant) + "\"?)"),
                     "use one of " + list(keys_));
    }
}

std::optional<JsonValue> JsonObject::find(std::string_view key) const {
    ENSURE(std::find(keys_.begin(), keys_.end(), key) != keys_.end(), "key ", key, " is not declared");
    return value_.member(key);
}

JsonValue JsonObject::required(std::string_view key) const {
    if (auto found = find(key)) return *found;
    const JsonValue missing(value_.document_, value_.json_, pointer_to(value_.pointer_, std::string(key)));
    missing.fail("is missing", "it is required");
}

void JsonObject::read(std::string_view key, double& target, const Range& range) const {
    if (auto found = find(key)) target = found->number(range);
}
void JsonObject::read(std::string_view key, int& target, int low, int high) const {
    if (auto found = find(key)) target = found->integer(low, high);
}
void JsonObject::read(std::string_view key, bool& target) const {
    if (auto found = find(key)) target = found->boolean();
}
void JsonObject::read(std::string_view key, std::string& target, std::size_t max_characters) const {
    if (auto found = find(key)) target = found->line(max_characters);
}
void JsonObject::read(std::string_view key, Vec3& target, const Range& each) const {
    if (auto found = find(key)) target = found->vector(each);
}

}  // namespace tetfront
