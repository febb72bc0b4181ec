#pragma once
// Reads typed values out of a JSON document; whatever does not fit throws an InputError that says where it is, what it
// is and what is allowed.
//
//     JsonObject material = JsonValue(document).object({"density", "poisson"});   // an unknown key throws
//     material.read("density", density, above(0, 1e6));                          // absent: stays as it is
//     material.required("poisson").number(below(0, 0.5));                        // absent: throws

#include "engine/base/types.hpp"
#include "engine/scene/json_document.hpp"

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetfront {

/// An interval of numbers; an open end is not part of it.
struct Range {
    double low, high;
    bool low_open = false, high_open = false;
    [[nodiscard]] bool contains(double x) const {
        return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high);
    }
    [[nodiscard]] std::string text() const;  // "[0, 0.5)"
};
constexpr Range within(double low, double high) { return {low, high, false, false}; }  // [low, high]
constexpr Range above(double low, double high) { return {low, high, true, false}; }    // (low, high]
constexpr Range below(double low, double high) { return {low, high, false, true}; }    // [low, high)
constexpr Range between(double low, double high) { return {low, high, true, true}; }   // (low, high)

/// Words of the format and what they mean.
template <class T>
using Choices = std::initializer_list<std::pair<std::string_view, T>>;

class JsonObject;

/// One value of a document and its JSON pointer. The document must outlive it.
class JsonValue {
 public:
    explicit JsonValue(const JsonDocument& document) : document_(&document), json_(&document.root) {}

    /// Throws InputError at this value: what is wrong ("is 0.7"), what is allowed ("use ..."). Names the overrides
    /// that set this value, a part of it or what it is part of.
    [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;

    [[nodiscard]] const std::string& pointer() const { return pointer_; }
    [[nodiscard]] bool is_number() const { return json_->is_number(); }
    [[nodiscard]] bool is_array() const { return json_->is_array(); }
    [[nodiscard]] bool is_object() const { return json_->is_object(); }
    /// JSON text for a message, cut to 40 bytes.
    [[nodiscard]] std::string text() const { return brief(*json_); }
    [[nodiscard]] double number(const Range& range) const;
    [[nodiscard]] int integer(int low, int high) const;
    [[nodiscard]] bool boolean() const;
    /// 1..max_characters characters without control characters.
    [[nodiscard]] std::string line(std::size_t max_characters) const;
    [[nodiscard]] Vec3 vector(const Range& each) const;
    [[nodiscard]] std::vector<JsonValue> array() const;
    [[nodiscard]] std::vector<JsonValue> array(std::size_t size) const;
    /// The value at `key` of an object of any keys; nothing when it is absent or this is not an object.
    [[nodiscard]] std::optional<JsonValue> member(std::string_view key) const;
    /// keys: all that are known. Throws for any other, and suggests the one that was meant.
    [[nodiscard]] JsonObject object(std::initializer_list<std::string_view> keys) const;
    /// An object with exactly one of `keys`: that key and its value.
    [[nodiscard]] std::pair<std::string, JsonValue> one_of(std::initializer_list<std::string_view> keys) const;
    template <class T>
    [[nodiscard]] T choice(Choices<T> choices) const {
        const std::string* word = string();
        std::string allowed;
        for (const auto& [name, meaning] : choices) {
            if (word && *word == name) return meaning;
            allowed += (allowed.empty() ? "\"" : ", \"") + std::string(name) + '"';
        }
        fail("is " + text(), "use one of " + allowed);
    }

 private:
    friend class JsonObject;
    JsonValue(const JsonDocument* document, const nlohmann::json* json, std::string pointer)
        : document_(document), json_(json), pointer_(std::move(pointer)) {}
    [[nodiscard]] const std::string* string() const;  // null when it is not one

    const JsonDocument* document_;
    const nlohmann::json* json_;
    std::string pointer_;
};

/// An object all of whose keys are known.
class JsonObject {
 public:
    [[nodiscard]] const JsonValue& value() const { return value_; }
    [[nodiscard]] std::optional<JsonValue> find(std::string_view key) const;
    [[nodiscard]] JsonValue required(std::string_view key) const;
    /// The value at `key`, or the object itself when it is absent: where to report what depends on it.
    [[nodiscard]] JsonValue place(std::string_view key) const { return find(key).value_or(value_); }

    // Each sets `target` when the key is there, and leaves it alone when not.
    void read(std::string_view key, double& target, const Range& range) const;
    void read(std::string_view key, int& target, int low, int high) const;
    void read(std::string_view key, bool& target) const;
    void read(std::string_view key, std::string& target, std::size_t max_characters) const;
    void read(std::string_view key, Vec3& target, const Range& each) const;
    template <class T>
    void read(std::string_view key, T& target, Choices<T> choices) const {
        if (auto found = find(key)) target = found->choice(choices);
    }

 private:
    friend class JsonValue;
    JsonObject(JsonValue value, std::initializer_list<std::string_view> keys);

    JsonValue value_;
    std::vector<std::string_view> keys_;
};

}  // namespace tetfront
