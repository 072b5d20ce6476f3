#include "kalfem/casefile/fields.hpp"

#include "kalfem/casefile/schema.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

bool holds(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

Json requirement(const Json& keys) { return {{"required", keys}}; }

}  // namespace

void report_unknown_keys(const Cursor& map, const std::vector<std::string>& known) {
  for (const auto& entry : map.node().entries)
    if (!holds(known, entry.key))
      map.at(entry).issue("unknown key" + did_you_mean(entry.key, known), "", "known here: " + join(known, ", "));
}

void report_missing_key(const Cursor& map, const std::string& key, const std::string& written,
                        const std::string& meaning) {
  map.issue("'" + key + "' is missing (" + meaning + ")", "", "add '" + key + ": " + written + "'");
}

std::optional<std::size_t> only_key(const Cursor& map, const std::vector<std::string>& keys, bool needed) {
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto* entry = map.node().find(keys[i]);
    if (!entry) continue;
    if (chosen) {
      map.at(*entry).issue("given beside '" + keys[*chosen] + "'", "only one of them can hold",
                           "keep one of " + join(keys, ", "));
      return std::nullopt;
    }
    chosen = i;
  }
  if (!chosen && needed) map.issue("one of " + join(keys, ", ") + " is missing", "", "add one of them");
  return chosen;
}

void report_keys_without_effect(const Cursor& map, const std::vector<std::vector<std::string>>& keys,
                                const std::vector<std::string>& names, std::size_t chosen) {
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (const auto& key : keys[i])
      if (const auto* entry = map.node().find(key); entry && !holds(keys[chosen], key))
        map.at(*entry).issue("belongs to '" + names[i] + "' but '" + names[chosen] + "' is given",
                             "it would have no effect", "remove it");
}

void describe_field(Json& object, const std::string& key, const Json& schema, const std::string& meaning, bool required,
                    const YamlNode* default_value) {
  Json property = schema;
  property["description"] = meaning;
  if (default_value) property["default"] = to_json(*default_value);
  object["properties"][key] = std::move(property);
  if (required) object["required"].push_back(key);
}

void describe_cases(Json& object, const std::vector<Json>& cases, const std::vector<std::string>& names, bool needed) {
  Json alternatives = Json::array(), any = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const auto& [key, property] : cases[i].at("properties").items()) {
      object["properties"].emplace(key, Json(property));
      object["properties"][key]["x-needed"] = key == names[i] ? "one of " + join(names, " | ") : "with " + names[i];
    }
    alternatives.push_back(requirement(cases[i].value("required", Json::array({names[i]}))));
    any.push_back(requirement({names[i]}));
  }
  if (!needed) alternatives.push_back({{"not", {{"anyOf", any}}}});
  object["allOf"].push_back({{"oneOf", alternatives}});
}

}  // namespace kalfem
