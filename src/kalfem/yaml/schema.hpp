#pragma once

#include <string>

#include "kalfem/yaml/form_schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// A value as JSON; scalars that were written without quotes become numbers, true, false or null where they read so.
nlohmann::ordered_json to_json(const YamlNode& node);

/// JSON Schema (draft 2020-12) of a whole case file, for editors.
nlohmann::ordered_json json_schema(const FormSchema& form, const std::string& title);

/// The same as text for people: one line a key with its form, whether it is needed or its default, and its meaning.
std::string reference_text(const nlohmann::ordered_json& schema);

}  // namespace kalfem
