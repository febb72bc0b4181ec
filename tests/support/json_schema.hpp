#pragma once
// The part of JSON Schema (draft 2020-12) that assets/schema uses, so that tests can hold documents against it. A
// keyword that is not known here throws: nothing in a schema goes unchecked.
//
//     EXPECT_EQ(JsonSchema(schema).error(document), "");

#include <algorithm>
#include <cmath>
#include <algorithm>
#include <stdexcept>
#include <stdexcept>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

namespace tetfront {

/// std::regex recurses once a character; the format uses one pattern only: no control characters.
inline bool matches(const std::string& text, const std::string& pattern) {
    if (pattern != R"(^[^\u0000-\u001f\u007f]*$)") throw std::invalid_argument("unknown pattern " + pattern);
    return std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

class JsonSchema {
 public:
    using json = nlohmann::json;
    explicit JsonSchema(json root) : root_(std::move(root)) {}

    [[nodiscard]] const json& root() const { return root_; }

    /// The first violation ("POINTER: KEYWORD"), or empty.
    [[nodiscard]] std::string error(const json& document) const { return error(root_, document, ""); }

    /// The node, or what its "$ref" names.
    [[nodiscard]] const json& resolve(const json& node) const {
        if (!node.contains("$ref")) return node;
        const std::string target = node["$ref"];
        if (target.substr(0, 2) != "#/") throw std::logic_error("only references into the schema itself: " + target);
        return resolve(root_.at(json::json_pointer(target.substr(1))));
    }

 private:
    [[nodiscard]] std::string error(const json& schema, const json& value, const std::string& at) const {
        for (const auto& [keyword, rule] : schema.items()) {
            const std::string found = check(schema, keyword, rule, value, at);
            if (!found.empty()) return found;
        }
        return "";
    }

    // NOLINTNEXTLINE(readability-function-cognitive-complexity): a list of keywords
    [[nodiscard]] std::string check(const json& schema, const std::string& keyword, const json& rule, const json& value,
                                    const std::string& at) const {
        const std::string violation = at + ": " + keyword;
        const auto unless = [&](bool holds) { return holds ? std::string() : violation; };
        const double number = value.is_number() ? value.get<double>() : 0;
        const std::size_t size = value.is_array() || value.is_object() ? value.size() : 0;

        if (keyword == "$schema" || keyword == "title" || keyword == "description" || keyword == "default" ||
            keyword == "$defs") {
            return "";
        }
        if (keyword == "$ref") return error(resolve(schema), value, at);
        if (keyword == "type") return unless(has_type(value, rule));
        if (keyword == "const") return unless(value == rule);
        if (keyword == "enum") return unless(std::find(rule.begin(), rule.end(), value) != rule.end());
        if (keyword == "oneOf") {
            int matches = 0;
            for (const json& option : rule) matches += error(option, value, at).empty() ? 1 : 0;
            return unless(matches == 1);
        }
        if (keyword == "minimum") return unless(!value.is_number() || number >= rule.get<double>());
        if (keyword == "maximum") return unless(!value.is_number() || number <= rule.get<double>());
        if (keyword == "exclusiveMinimum") return unless(!value.is_number() || number > rule.get<double>());
        if (keyword == "exclusiveMaximum") return unless(!value.is_number() || number < rule.get<double>());
        if (keyword == "minLength") return unless(!value.is_string() || characters(value) >= rule.get<std::size_t>());
        if (keyword == "maxLength") return unless(!value.is_string() || characters(value) <= rule.get<std::size_t>());
        if (keyword == "pattern") {
            return unless(!value.is_string() ||
                          matches(value.get<std::string>(), rule.get<std::string>()));
        }
        if (keyword == "minItems") return unless(!value.is_array() || size >= rule.get<std::size_t>());
        if (keyword == "maxItems") return unless(!value.is_array() || size <= rule.get<std::size_t>());
        if (keyword == "minProperties") return unless(!value.is_object() || size >= rule.get<std::size_t>());
        if (keyword == "maxProperties") return unless(!value.is_object() || size <= rule.get<std::size_t>());
        if (keyword == "items") {
            for (std::size_t i = 0; value.is_array() && i < size; ++i) {
                if (std::string e = error(rule, value[i], at + '/' + std::to_string(i)); !e.empty()) return e;
            }
            return "";
        }
        if (keyword == "properties") {
            for (const auto& [key, property] : rule.items()) {
                if (!value.is_object() || !value.contains(key)) continue;
                if (std::string e = error(property, value[key], at + '/' + key); !e.empty()) return e;
            }
            return "";
        }
        if (keyword == "additionalProperties") {
            if (rule != json(false)) throw std::logic_error("additionalProperties must be false");
            if (!value.is_object()) return "";
            for (const auto& [key, ignored] : value.items()) {
                if (!schema.at("properties").contains(key)) return at + '/' + key + ": " + keyword;
            }
            return "";
        }
        if (keyword == "required") {
            for (const json& key : rule) {
                if (value.is_object() && !value.contains(key.get<std::string>())) return violation;
            }
            return "";
        }
        if (keyword == "dependentRequired") {
            for (const auto& [key, others] : rule.items()) {
                for (const json& other : others) {
                    if (value.is_object() && value.contains(key) && !value.contains(other.get<std::string>()))
                        return violation;
                }
            }
            return "";
        }
        throw std::logic_error("JSON Schema keyword that this validator does not know: " + keyword);
    }

    static bool has_type(const json& value, const std::string& type) {
        if (type == "object") return value.is_object();
        if (type == "array") return value.is_array();
        if (type == "string") return value.is_string();
        if (type == "boolean") return value.is_boolean();
        if (type == "number") return value.is_number();
        if (type == "integer") return value.is_number() && value.get<double>() == std::floor(value.get<double>());
        throw std::logic_error("type that this validator does not know: " + type);
    }

    static std::size_t characters(const json& text) {
        const auto& bytes = text.get_ref<const std::string&>();
        return static_cast<std::size_t>(std::count_if(
            bytes.begin(), bytes.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
    }

    json root_;
};

}  // namespace tetfront
