// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// A schema as JSON Schema (draft 2020-12), with three keywords of our own: "x-written", the schema in a few English
/// words, "x-unit", and "x-needed", which states when a key of alternatives is needed. Immutable and shared, as schemas
/// nest.
class JsonSchema {
public:
  JsonSchema();
  explicit JsonSchema(nlohmann::ordered_json json);

  [[nodiscard]] const nlohmann::ordered_json& json() const { return *json_; }
  [[nodiscard]] std::string written() const;
  [[nodiscard]] std::string unit() const;
  /// The same schema with another text for "x-written".
  [[nodiscard]] JsonSchema written_as(const std::string& written) const;

private:
  std::shared_ptr<const nlohmann::ordered_json> json_;
};

/// A text or a number.
JsonSchema scalar_schema(const std::string& written);
/// One of the words, each with its meaning.
JsonSchema choice_schema(const std::vector<std::string>& words, const std::vector<std::string>& meanings);
JsonSchema list_schema(const JsonSchema& item, std::size_t least, std::size_t most);
/// "a or b".
JsonSchema either_schema(const JsonSchema& one, const JsonSchema& other);
/// Names that the user chooses, each with such an item.
JsonSchema named_schema(const JsonSchema& item);

/// A value as JSON. Scalars written without quotes become numbers, true, false or null if they read as such.
nlohmann::ordered_json to_json(const YamlNode& node);

/// JSON Schema (draft 2020-12) of a whole case file, for editors.
nlohmann::ordered_json whole_json_schema(const JsonSchema& schema, const std::string& title);

/// The same as text: one line per key with its schema, its default or "required", and its meaning.
std::string reference_text(const nlohmann::ordered_json& json_schema);

}  // namespace kalfem
