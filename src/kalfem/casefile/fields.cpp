#include "kalfem/casefile/fields.hpp"

#include <nlohmann/json.hpp>

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

void report_unknown_keys(const Cursor& map, const std::vector<std::string>& known) {
  for (const auto& entry : map.node().entries)
    if (!holds(known, entry.key))
      map.at(entry).issue("unknown key" + did_you_mean(entry.key, known), "", "known here: " + join(known, ", "));
}

/// Index of the only key that the map has, or nothing; adds an issue for two keys, or for none when one is `needed`.
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

/// Issues for the keys of the alternatives that were not chosen.
void report_keys_without_effect(const Cursor& map, const std::vector<BoundKeys>& cases,
                                const std::vector<std::string>& names, std::size_t chosen) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    for (const auto& key : cases[i].keys)
      if (const auto* entry = map.node().find(key); entry && !holds(cases[chosen].keys, key))
        map.at(*entry).issue("belongs to '" + names[i] + "' but '" + names[chosen] + "' is given",
                             "it would have no effect", "remove it");
}

void describe_cases(Json& object, const std::vector<BoundKeys>& cases, const std::vector<std::string>& names,
                    bool needed) {
  Json alternatives = Json::array(), any = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Json alternative;
    cases[i].describe(alternative);
    for (const auto& [key, property] : alternative.at("properties").items()) {
      object["properties"].emplace(key, Json(property));
      object["properties"][key]["x-needed"] = key == names[i] ? "one of " + join(names, " | ") : "with " + names[i];
    }
    alternatives.push_back(requirement(alternative.value("required", Json::array({names[i]}))));
    any.push_back(requirement({names[i]}));
  }
  if (!needed) alternatives.push_back({{"not", {{"anyOf", any}}}});
  object["allOf"].push_back({{"oneOf", alternatives}});
}

std::vector<std::string> all_keys(const std::vector<BoundKeys>& parts) {
  std::vector<std::string> keys;
  for (const auto& each : parts) keys.insert(keys.end(), each.keys.begin(), each.keys.end());
  return keys;
}

}  // namespace

BoundKeys bind_field(const FieldWords& words, const BoundForm& form, const Place& place,
                     const YamlNodePtr& default_value) {
  const std::string key(words.key), meaning(words.meaning);
  const bool required = words.required;
  const auto read = [=](const Cursor& map, void* object) {
    if (const auto* entry = map.node().find(key))
      form.read(map.at(*entry), const_cast<void*>(place(object)));
    else if (required)
      map.issue("'" + key + "' is missing (" + meaning + ")", "", "add '" + key + ": " + form.schema.written() + "'");
  };
  const auto write = [=](const void* object, std::vector<YamlEntry>& entries) {
    if (auto value = form.write(place(object))) entries.push_back({key, 0, std::move(value)});
  };
  const auto describe = [=](Json& object) {
    Json property = form.schema.json();
    property["description"] = meaning;
    if (default_value) property["default"] = to_json(*default_value);
    object["properties"][key] = std::move(property);
    if (required) object["required"].push_back(key);
  };
  return {{key}, read, write, describe};
}

BoundKeys bind_one_of(std::vector<std::string> names, std::vector<BoundKeys> cases, bool needed) {
  struct Alternatives {
    std::vector<std::string> names;
    std::vector<BoundKeys> cases;
  };
  auto keys = all_keys(cases);
  const auto all = std::make_shared<const Alternatives>(Alternatives{std::move(names), std::move(cases)});
  return {std::move(keys),
          [=](const Cursor& map, void* object) {
            const auto chosen = only_key(map, all->names, needed);
            if (!chosen) return;
            report_keys_without_effect(map, all->cases, all->names, *chosen);
            all->cases[*chosen].read(map, object);
          },
          [=](const void* object, std::vector<YamlEntry>& entries) {
            for (const auto& each : all->cases) each.write(object, entries);
          },
          [=](Json& schema) { describe_cases(schema, all->cases, all->names, needed); }};
}

BoundKeys bind_all(std::vector<BoundKeys> fields, std::vector<std::function<std::vector<Issue>(const void*)>> checks) {
  auto keys = all_keys(fields);
  const auto all = std::make_shared<const std::vector<BoundKeys>>(std::move(fields));
  return {std::move(keys),
          [=](const Cursor& map, void* object) {
            const std::size_t before = map.issue_count();
            for (const auto& field : *all) field.read(map, object);
            if (map.issue_count() != before) return;
            for (const auto& validate : checks)
              if (const auto issues = validate(object); !issues.empty()) map.issue(InvalidInput(issues));
          },
          [=](const void* object, std::vector<YamlEntry>& entries) {
            for (const auto& field : *all) field.write(object, entries);
          },
          [=](Json& schema) {
            for (const auto& field : *all) field.describe(schema);
          }};
}

bool read_map(const Cursor& cursor, const BoundKeys& fields, const FormSchema& schema, void* object) {
  if (cursor.node().kind != YamlNode::Kind::null && !cursor.require(YamlNode::Kind::map, schema.written()))
    return false;
  const std::size_t before = cursor.issue_count();
  report_unknown_keys(cursor, fields.keys);
  fields.read(cursor, object);
  return cursor.issue_count() == before;
}

YamlNodePtr write_map(const BoundKeys& fields, const void* object) {
  std::vector<YamlEntry> entries;
  fields.write(object, entries);
  return yaml_map(entries);
}

FormSchema map_schema(const BoundKeys& fields) {
  Json json{{"type", "object"}, {"additionalProperties", false}, {"x-written", "{" + join(fields.keys, ", ") + "}"}};
  fields.describe(json);
  return FormSchema(std::move(json));
}

}  // namespace kalfem
