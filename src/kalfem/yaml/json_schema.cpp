// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/json_schema.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace kalfem {

namespace {
using Json = nlohmann::ordered_json;
}

JsonSchema::JsonSchema() : JsonSchema(Json::object()) {}
JsonSchema::JsonSchema(Json json) : json_(std::make_shared<const Json>(std::move(json))) {}

std::string JsonSchema::written() const { return json_->value("x-written", ""); }
std::string JsonSchema::unit() const { return json_->value("x-unit", ""); }

JsonSchema JsonSchema::written_as(const std::string& written) const {
  Json json = *json_;
  json["x-written"] = written;
  return JsonSchema(std::move(json));
}

JsonSchema scalar_schema(const std::string& written) {
  return JsonSchema(Json{{"type", {"string", "number"}}, {"x-written", written}});
}

JsonSchema choice_schema(const std::vector<std::string>& words, const std::vector<std::string>& meanings) {
  std::string joined;
  Json alternatives = Json::array();
  for (std::size_t i = 0; i < words.size(); ++i) {
    joined += (joined.empty() ? "" : " | ") + words[i];
    alternatives.push_back({{"const", words[i]}, {"description", meanings[i]}});
  }
  return JsonSchema(Json{{"oneOf", alternatives}, {"x-written", joined}});
}

JsonSchema list_schema(const JsonSchema& item, std::size_t least, std::size_t most) {
  Json json{{"type", "array"}, {"items", item.json()}, {"x-written", "[" + item.written() + ", ...]"}};
  if (least > 0) json["minItems"] = least;
  if (most != std::numeric_limits<std::size_t>::max()) json["maxItems"] = most;
  return JsonSchema(std::move(json));
}

JsonSchema either_schema(const JsonSchema& one, const JsonSchema& other) {
  return JsonSchema(
      Json{{"anyOf", {one.json(), other.json()}}, {"x-written", one.written() + " or " + other.written()}});
}

JsonSchema named_schema(const JsonSchema& item) {
  return JsonSchema(Json{
      {"type", "object"}, {"additionalProperties", item.json()}, {"x-written", "{name: " + item.written() + ", ...}"}});
}

namespace {

constexpr std::size_t meaning_column = 56;

/// A scalar in quotes stays text. Otherwise it becomes true, false, a whole number or a finite number if it reads as
/// one.
Json scalar_json(const YamlNode& node) {
  if (!node.literal) return node.text;
  if (node.text == "true" || node.text == "false") return node.text == "true";
  const char *begin = node.text.data(), *end = begin + node.text.size();
  std::uint64_t whole = 0;
  if (const auto [stop, error] = std::from_chars(begin, end, whole); error == std::errc{} && stop == end) return whole;
  double number = 0.0;
  if (const auto [stop, error] = std::from_chars(begin, end, number);
      error == std::errc{} && stop == end && std::isfinite(number))
    return number;
  return node.text;
}

std::string line(const std::string& left, const std::string& meaning) {
  const std::string gap = left.size() + 2 > meaning_column ? "  " : std::string(meaning_column - left.size(), ' ');
  return left + (meaning.empty() ? "" : gap + meaning) + "\n";
}

bool is_needed(const Json& object, const std::string& key) {
  const Json needed = object.value("required", Json::array());
  return std::find(needed.begin(), needed.end(), key) != needed.end();
}

std::string qualifier(const Json& object, const std::string& key, const Json& property) {
  if (property.contains("x-needed")) return " (" + property["x-needed"].get<std::string>() + ")";
  if (is_needed(object, key)) return " (required)";
  if (property.contains("default") && !property["default"].is_object())
    return " (default " + property["default"].dump() + ")";
  return "";
}

/// The lines below the line of a key: its own keys, those of its items or alternatives, and the words of a choice with
/// their meanings. An item or alternative that has nothing to tell adds no line, so the text stays short.
std::string below(const Json& json_schema, const std::string& indent) {
  std::string text;
  if (json_schema.contains("properties"))
    for (const auto& [key, property] : json_schema["properties"].items()) {
      const std::string written = below(property, "").empty() ? " " + property.value("x-written", "") : "";
      text +=
          line(indent + key + ":" + written + qualifier(json_schema, key, property), property.value("description", ""));
      text += below(property, indent + "  ");
    }
  if (json_schema.contains("additionalProperties") && json_schema["additionalProperties"].is_object()) {
    const Json& item = json_schema["additionalProperties"];
    const std::string inner = below(item, indent + "  ");
    text += indent + "<name>:" + (inner.empty() ? " " + item.value("x-written", "") : "") + "\n" + inner;
  }
  if (json_schema.contains("items"))
    if (const std::string inner = below(json_schema["items"], indent + "  "); !inner.empty())
      text += indent + "- each:\n" + inner;
  for (const auto& alternative : json_schema.value("anyOf", Json::array()))
    if (const std::string inner = below(alternative, indent + "  "); !inner.empty())
      text += indent + "or " + alternative.value("x-written", "") + "\n" + inner;
  for (const auto& word : json_schema.value("oneOf", Json::array()))
    if (const std::string meaning = word.value("description", ""); !meaning.empty())
      text += line(indent + "  = " + word.value("const", ""), meaning);
  return text;
}

}  // namespace

Json to_json(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null:
      return nullptr;
    case YamlNode::Kind::scalar:
      return scalar_json(node);
    case YamlNode::Kind::list: {
      Json list = Json::array();
      for (const auto& item : node.items) list.push_back(to_json(*item));
      return list;
    }
    case YamlNode::Kind::map:
      break;
  }
  Json map = Json::object();
  for (const auto& entry : node.entries) map[entry.key] = to_json(*entry.value);
  return map;
}

Json whole_json_schema(const JsonSchema& schema, const std::string& title) {
  Json json_schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
  json_schema.update(schema.json());
  return json_schema;
}

std::string reference_text(const Json& json_schema) { return below(json_schema, ""); }

}  // namespace kalfem
