// SPDX-License-Identifier: Apache-2.0
#include "law_schema.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "kalfem/system/laws/law_library.hpp"

namespace kalfem::command {
namespace {

using Json = nlohmann::ordered_json;

/// The names that the parameters of a law may have; nothing if the case chooses them.
Json parameter_names(const LawDescription& law) {
  if (law.name == "expression") return nullptr;
  if (law.name == "polynomial") return {{"pattern", "^[kc][0-9]+$"}};
  if (law.name == "prony") return {{"pattern", "^(k_inf|c|(k|tau)[1-8])$"}};
  Json names = Json::array();
  for (const auto& parameter : law.parameters) names.push_back(parameter.name);
  return {{"enum", names}};
}

std::string parameters_in_words(const LawDescription& law) {
  std::string words;
  for (const auto& parameter : law.parameters)
    words += fmt::format("{}{} [{}]: {}", words.empty() ? "" : "; ", parameter.name, parameter.unit, parameter.meaning);
  return words;
}

Json law_names() {
  Json names = Json::array();
  for (const auto& law : law_library())
    names.push_back({{"const", law.name},
                     {"description", fmt::format("{}: {}. {}", law.meaning, law.equation, parameters_in_words(law))}});
  names.push_back({{"$ref", "#/$defs/environment"}});
  return names;
}

/// If the law has this name, then its parameters have these.
Json parameters_by_law() {
  Json conditions = Json::array();
  for (const auto& law : law_library())
    if (Json names = parameter_names(law); !names.is_null())
      conditions.push_back({{"if", {{"properties", {{"law", {{"const", law.name}}}}}, {"required", {"law"}}}},
                            {"then", {{"properties", {{"parameters", {{"propertyNames", std::move(names)}}}}}}}});
  return conditions;
}

}  // namespace

void add_laws(Json& schema) {
  for (auto& inner : schema)
    if (inner.is_structured()) add_laws(inner);
  if (!schema.is_object() || !schema.contains("properties")) return;
  Json& properties = schema["properties"];
  if (!properties.contains("law") || !properties.contains("parameters")) return;
  Json law = {{"anyOf", law_names()}};
  for (const char* key : {"description", "x-written"})
    if (properties["law"].contains(key)) law[key] = properties["law"][key];
  properties["law"] = std::move(law);
  schema["allOf"] = parameters_by_law();
}

}  // namespace kalfem::command
