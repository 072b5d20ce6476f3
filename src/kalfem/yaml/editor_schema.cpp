// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/editor_schema.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/base/version.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* environment = "#/$defs/environment";

/// A number, perhaps with a unit behind it, or a variable of the environment.
constexpr const char* quantity_pattern = R"(^\s*[-+]?\.?([0-9]|[iI]nf)|\$\{)";
constexpr const char* name_pattern = "^[A-Za-z0-9_.-]+$";

/// Keywords that describe a value for people stay outside of the alternatives.
constexpr const char* annotations[] = {"description", "default", "x-written", "x-unit", "x-needed"};

/// The schema, or a text with a variable.
Json or_environment(Json schema) {
  Json outer = Json::object();
  for (const char* key : annotations)
    if (const auto found = schema.find(key); found != schema.end()) {
      outer[key] = std::move(*found);
      schema.erase(key);
    }
  outer["anyOf"] = {std::move(schema), {{"$ref", environment}}};
  return outer;
}

bool is_scalar_without_text(const Json& schema) {
  if (schema.contains("oneOf")) return true;
  const Json type = schema.value("type", Json());
  return type == "integer" || type == "boolean";
}

bool is_number(const Json& schema) {
  return schema.value("type", Json()).is_array() && schema.value("x-written", std::string()).starts_with("number");
}

Json with_environment(Json schema) {
  const auto change = [](Json& inner) { inner = with_environment(std::move(inner)); };
  for (const char* group : {"properties", "anyOf"})
    if (const auto found = schema.find(group); found != schema.end()) std::ranges::for_each(*found, change);
  if (schema.contains("items")) change(schema["items"]);
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
    change(schema["additionalProperties"]);
    schema["propertyNames"] = {{"pattern", name_pattern}};
  }
  if (is_number(schema)) schema["pattern"] = quantity_pattern;
  if (schema.value("type", Json()) == "object") schema["type"] = {"object", "null"};
  return is_scalar_without_text(schema) ? or_environment(std::move(schema)) : schema;
}

}  // namespace

Json editor_schema(Json whole) {
  Json schema{{"$schema", whole.at("$schema")}, {"$id", "urn:kalfem:case-file:" + std::string(version)}};
  whole = with_environment(std::move(whole));
  whole["type"] = "object";
  whole.erase("$schema");
  schema.update(whole);
  schema["$defs"]["environment"] = {{"type", "string"},
                                    {"pattern", R"(\$\{)"},
                                    {"description", "${NAME} or ${NAME:-default}: a variable of the environment"}};
  return schema;
}

}  // namespace kalfem
