// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/map_schema.hpp"

#include <nlohmann/json.hpp>

#include "kalfem/yaml/json_schema.hpp"

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

void report_unknown_keys(const CaseNode& map, const std::vector<std::string>& known) {
  for (const auto& entry : map.yaml().entries)
    if (!holds(known, entry.key))
      map.at(entry).issue("unknown key" + did_you_mean(entry.key, known), "", "allowed here: " + join(known, ", "));
}

/// Index of the only one of the keys that the map has, or nothing. Adds an issue for two keys, and for none if one is
/// `needed`.
std::optional<std::size_t> only_key(const CaseNode& map, const std::vector<std::string>& keys, bool needed) {
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto* entry = map.yaml().find(keys[i]);
    if (!entry) continue;
    if (chosen) {
      map.at(*entry).issue("given together with '" + keys[*chosen] + "'", "only one of them can apply",
                           "keep one of " + join(keys, ", "));
      return std::nullopt;
    }
    chosen = i;
  }
  if (!chosen && needed) map.issue("one of " + join(keys, ", ") + " is missing", "", "add one of them");
  return chosen;
}

/// Issues for the keys of the alternatives that were not chosen.
void report_keys_without_effect(const CaseNode& map, const std::vector<FieldPtr>& cases,
                                const std::vector<std::string>& names, std::size_t chosen) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    for (const auto& key : cases[i]->keys)
      if (const auto* entry = map.yaml().find(key); entry && !holds(cases[chosen]->keys, key))
        map.at(*entry).issue("applies only with '" + names[i] + "' but '" + names[chosen] + "' is given",
                             "it would have no effect", "remove it");
}

void describe_cases(Json& object, const std::vector<FieldPtr>& cases, const std::vector<std::string>& names,
                    bool needed) {
  Json alternatives = Json::array(), any = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Json alternative;
    cases[i]->document(alternative);
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

std::vector<std::string> all_keys(const std::vector<FieldPtr>& parts) {
  std::vector<std::string> keys;
  for (const auto& each : parts) keys.insert(keys.end(), each->keys.begin(), each->keys.end());
  return keys;
}

const void* at(MemberOffset offset, const void* object) { return static_cast<const std::byte*>(object) + offset; }
void* at(MemberOffset offset, void* object) { return static_cast<std::byte*>(object) + offset; }

/// One key whose value is a member.
class FieldKey final : public Field {
public:
  FieldKey(const FieldInfo& words, AnySchemaPtr schema, MemberOffset offset, YamlNodePtr default_value)
      : Field({std::string(words.key)}),
        key_(words.key),
        meaning_(words.meaning),
        required_(words.required),
        schema_(std::move(schema)),
        offset_(offset),
        default_value_(std::move(default_value)) {}

  void read(const CaseNode& map, void* object) const override {
    if (const auto* entry = map.yaml().find(key_))
      schema_->read(map.at(*entry), at(offset_, object));
    else if (required_)
      map.issue("'" + key_ + "' is missing (" + meaning_ + ")", "",
                "add '" + key_ + ": " + schema_->json_schema.written() + "'");
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    if (auto value = schema_->write(at(offset_, object))) entries.push_back({key_, 0, std::move(value)});
  }
  void document(Json& json_schema) const override {
    Json property = schema_->json_schema.json();
    property["description"] = meaning_;
    if (default_value_) property["default"] = to_json(*default_value_);
    json_schema["properties"][key_] = std::move(property);
    if (required_) json_schema["required"].push_back(key_);
  }

private:
  std::string key_, meaning_;
  bool required_;
  AnySchemaPtr schema_;
  MemberOffset offset_;
  YamlNodePtr default_value_;
};

/// The keys of a member, in the map of its owner.
class InlinedKeys final : public Field {
public:
  InlinedKeys(const FieldPtr& inner, MemberOffset offset) : Field(inner->keys), inner_(inner), offset_(offset) {}

  void read(const CaseNode& map, void* object) const override { inner_->read(map, at(offset_, object)); }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    inner_->write(at(offset_, object), entries);
  }
  void document(Json& json_schema) const override { inner_->document(json_schema); }

private:
  FieldPtr inner_;
  MemberOffset offset_;
};

/// The keys of a type that a variant member may hold.
class HeldKeys final : public Field {
public:
  HeldKeys(const FieldPtr& fields, const VariantAccess& type, MemberOffset offset)
      : Field(fields->keys), fields_(fields), type_(type), offset_(offset) {}

  void read(const CaseNode& map, void* object) const override { type_.read(*fields_, map, at(offset_, object)); }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    if (const void* held = type_.held(at(offset_, object))) fields_->write(held, entries);
  }
  void document(Json& json_schema) const override { fields_->document(json_schema); }

private:
  FieldPtr fields_;
  VariantAccess type_;
  MemberOffset offset_;
};

/// One of several cases.
class AlternativeKeys final : public Field {
public:
  AlternativeKeys(std::vector<std::string> names, std::vector<FieldPtr> cases, bool needed)
      : Field(all_keys(cases)), names_(std::move(names)), cases_(std::move(cases)), needed_(needed) {}

  void read(const CaseNode& map, void* object) const override {
    const auto chosen = only_key(map, names_, needed_);
    if (!chosen) return;
    report_keys_without_effect(map, cases_, names_, *chosen);
    cases_[*chosen]->read(map, object);
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    for (const auto& each : cases_) each->write(object, entries);
  }
  void document(Json& json_schema) const override { describe_cases(json_schema, cases_, names_, needed_); }

private:
  std::vector<std::string> names_;
  std::vector<FieldPtr> cases_;
  bool needed_;
};

/// All keys of an object, and its checks. The checks run only if every key is right: they may rely on the values.
class AllKeys final : public Field {
public:
  AllKeys(std::vector<FieldPtr> fields, std::vector<FieldTable::Check> checks)
      : Field(all_keys(fields)), fields_(std::move(fields)), checks_(std::move(checks)) {}

  void read(const CaseNode& map, void* object) const override {
    const std::size_t before = map.issue_count();
    for (const auto& field : fields_) field->read(map, object);
    if (map.issue_count() != before) return;
    for (const auto& validate : checks_)
      if (const auto issues = validate(object); !issues.empty()) map.issue(InvalidInput(issues));
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    for (const auto& field : fields_) field->write(object, entries);
  }
  void document(Json& json_schema) const override {
    for (const auto& field : fields_) field->document(json_schema);
  }

private:
  std::vector<FieldPtr> fields_;
  std::vector<FieldTable::Check> checks_;
};

JsonSchema map_schema(const Field& keys) {
  Json json{{"type", "object"}, {"additionalProperties", false}, {"x-written", "{" + join(keys.keys, ", ") + "}"}};
  keys.document(json);
  return JsonSchema(std::move(json));
}

class MapSchema final : public AnySchema {
public:
  explicit MapSchema(FieldPtr keys) : AnySchema(map_schema(*keys)), keys_(std::move(keys)) {}

  bool read(const CaseNode& node, void* object) const override {
    if (node.yaml().kind != YamlNode::Kind::null && !node.require(YamlNode::Kind::map, json_schema.written()))
      return false;
    const std::size_t before = node.issue_count();
    report_unknown_keys(node, keys_->keys);
    keys_->read(node, object);
    return node.issue_count() == before;
  }
  YamlNodePtr write(const void* object) const override {
    std::vector<YamlEntry> entries;
    keys_->write(object, entries);
    return yaml_map(entries);
  }

private:
  FieldPtr keys_;
};

}  // namespace

FieldPtr bind_field(const FieldInfo& words, const AnySchemaPtr& schema, MemberOffset offset,
                    const YamlNodePtr& default_value) {
  return std::make_shared<const FieldKey>(words, schema, offset, default_value);
}

FieldPtr bind_inlined(const FieldPtr& inner, MemberOffset offset) {
  return std::make_shared<const InlinedKeys>(inner, offset);
}

FieldPtr bind_held(const FieldPtr& fields, const VariantAccess& type, MemberOffset offset) {
  return std::make_shared<const HeldKeys>(fields, type, offset);
}

FieldPtr bind_one_of(std::vector<std::string> names, std::vector<FieldPtr> cases, bool needed) {
  return std::make_shared<const AlternativeKeys>(std::move(names), std::move(cases), needed);
}

FieldTable::FieldTable() = default;
FieldTable::FieldTable(const FieldTable&) = default;
FieldTable::~FieldTable() = default;

FieldPtr FieldTable::as_one_field() const { return std::make_shared<const AllKeys>(fields_, checks_); }

void FieldTable::add(FieldPtr keys) { fields_.push_back(std::move(keys)); }
void FieldTable::add(Check check) { checks_.push_back(std::move(check)); }

AnySchemaPtr map_schema(const FieldPtr& keys) { return std::make_shared<const MapSchema>(keys); }

}  // namespace kalfem
