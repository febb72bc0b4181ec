#pragma once
// The part of JSON Schema (draft 2020-12) that assets/schema uses, so that tests can hold documents against it. A
// keyword that is not known here throws: nothing in a schema goes unchecked.
//
//     EXPECT_EQ(schema_error(schema, document), "");

#include <string>

#include <nlohmann/json.hpp>

namespace tetfront {

/// The first violation ("POINTER: KEYWORD"), or empty. Throws std::logic_error for an unknown keyword.
std::string schema_error(const nlohmann::json& schema, const nlohmann::json& document);

/// The schema node with its "$ref" (to "#/$defs/NAME") followed.
const nlohmann::json& resolve(const nlohmann::json& schema, const nlohmann::json& node);

}  // namespace tetfront
