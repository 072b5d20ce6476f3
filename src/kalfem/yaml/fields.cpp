#include "kalfem/yaml/fields.hpp"

#include <nlohmann/json.hpp>

#include "kalfem/yaml/schema.hpp"

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
      map.at(entry).issue("unknown key" + did_you_mean(entry.key, known), "", "allowed here: " + join(known, ", "));
}

/// Index of the only key that the map has, or nothing; adds an issue for two keys, or for none when one is `needed`.
std::optional<std::size_t> only_key(const Cursor& map, const std::vector<std::string>& keys, bool needed) {
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto* entry = map.node().find(keys[i]);
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
void report_keys_without_effect(const Cursor& map, const std::vector<BoundKeysPtr>& cases,
                                const std::vector<std::string>& names, std::size_t chosen) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    for (const auto& key : cases[i]->keys)
      if (const auto* entry = map.node().find(key); entry && !holds(cases[chosen]->keys, key))
        map.at(*entry).issue("applies only with '" + names[i] + "' but '" + names[chosen] + "' is given",
                             "it would have no effect", "remove it");
}

void describe_cases(Json& object, const std::vector<BoundKeysPtr>& cases, const std::vector<std::string>& names,
                    bool needed) {
  Json alternatives = Json::array(), any = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Json alternative;
    cases[i]->describe(alternative);
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

std::vector<std::string> all_keys(const std::vector<BoundKeysPtr>& parts) {
  std::vector<std::string> keys;
  for (const auto& each : parts) keys.insert(keys.end(), each->keys.begin(), each->keys.end());
  return keys;
}

const void* at(Place place, const void* object) { return static_cast<const std::byte*>(object) + place; }
void* at(Place place, void* object) { return static_cast<std::byte*>(object) + place; }

/// One key whose value is a member.
class FieldKey final : public BoundKeys {
public:
  FieldKey(const FieldWords& words, AnyFormPtr form, Place place, YamlNodePtr default_value)
      : BoundKeys({std::string(words.key)}),
        key_(words.key),
        meaning_(words.meaning),
        required_(words.required),
        form_(std::move(form)),
        place_(place),
        default_value_(std::move(default_value)) {}

  void read(const Cursor& map, void* object) const override {
    if (const auto* entry = map.node().find(key_))
      form_->read(map.at(*entry), at(place_, object));
    else if (required_)
      map.issue("'" + key_ + "' is missing (" + meaning_ + ")", "",
                "add '" + key_ + ": " + form_->schema.written() + "'");
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    if (auto value = form_->write(at(place_, object))) entries.push_back({key_, 0, std::move(value)});
  }
  void describe(Json& schema) const override {
    Json property = form_->schema.json();
    property["description"] = meaning_;
    if (default_value_) property["default"] = to_json(*default_value_);
    schema["properties"][key_] = std::move(property);
    if (required_) schema["required"].push_back(key_);
  }

private:
  std::string key_, meaning_;
  bool required_;
  AnyFormPtr form_;
  Place place_;
  YamlNodePtr default_value_;
};

/// The keys of a member, in the map of its owner.
class InlinedKeys final : public BoundKeys {
public:
  InlinedKeys(const BoundKeysPtr& inner, Place place) : BoundKeys(inner->keys), inner_(inner), place_(place) {}

  void read(const Cursor& map, void* object) const override { inner_->read(map, at(place_, object)); }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    inner_->write(at(place_, object), entries);
  }
  void describe(Json& schema) const override { inner_->describe(schema); }

private:
  BoundKeysPtr inner_;
  Place place_;
};

/// The keys of what a member may hold.
class HeldKeys final : public BoundKeys {
public:
  HeldKeys(const BoundKeysPtr& fields, const HeldType& type, Place place)
      : BoundKeys(fields->keys), fields_(fields), type_(type), place_(place) {}

  void read(const Cursor& map, void* object) const override { type_.read(*fields_, map, at(place_, object)); }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    if (const void* held = type_.held(at(place_, object))) fields_->write(held, entries);
  }
  void describe(Json& schema) const override { fields_->describe(schema); }

private:
  BoundKeysPtr fields_;
  HeldType type_;
  Place place_;
};

/// One of several cases.
class AlternativeKeys final : public BoundKeys {
public:
  AlternativeKeys(std::vector<std::string> names, std::vector<BoundKeysPtr> cases, bool needed)
      : BoundKeys(all_keys(cases)), names_(std::move(names)), cases_(std::move(cases)), needed_(needed) {}

  void read(const Cursor& map, void* object) const override {
    const auto chosen = only_key(map, names_, needed_);
    if (!chosen) return;
    report_keys_without_effect(map, cases_, names_, *chosen);
    cases_[*chosen]->read(map, object);
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    for (const auto& each : cases_) each->write(object, entries);
  }
  void describe(Json& schema) const override { describe_cases(schema, cases_, names_, needed_); }

private:
  std::vector<std::string> names_;
  std::vector<BoundKeysPtr> cases_;
  bool needed_;
};

/// All keys of an object, and its checks.
class AllKeys final : public BoundKeys {
public:
  AllKeys(std::vector<BoundKeysPtr> fields, std::vector<FieldTable::Check> checks)
      : BoundKeys(all_keys(fields)), fields_(std::move(fields)), checks_(std::move(checks)) {}

  void read(const Cursor& map, void* object) const override {
    const std::size_t before = map.issue_count();
    for (const auto& field : fields_) field->read(map, object);
    if (map.issue_count() != before) return;
    for (const auto& validate : checks_)
      if (const auto issues = validate(object); !issues.empty()) map.issue(InvalidInput(issues));
  }
  void write(const void* object, std::vector<YamlEntry>& entries) const override {
    for (const auto& field : fields_) field->write(object, entries);
  }
  void describe(Json& schema) const override {
    for (const auto& field : fields_) field->describe(schema);
  }

private:
  std::vector<BoundKeysPtr> fields_;
  std::vector<FieldTable::Check> checks_;
};

FormSchema map_schema(const BoundKeys& keys) {
  Json json{{"type", "object"}, {"additionalProperties", false}, {"x-written", "{" + join(keys.keys, ", ") + "}"}};
  keys.describe(json);
  return FormSchema(std::move(json));
}

class MapForm final : public AnyForm {
public:
  explicit MapForm(BoundKeysPtr keys) : AnyForm(map_schema(*keys)), keys_(std::move(keys)) {}

  bool read(const Cursor& cursor, void* object) const override {
    if (cursor.node().kind != YamlNode::Kind::null && !cursor.require(YamlNode::Kind::map, schema.written()))
      return false;
    const std::size_t before = cursor.issue_count();
    report_unknown_keys(cursor, keys_->keys);
    keys_->read(cursor, object);
    return cursor.issue_count() == before;
  }
  YamlNodePtr write(const void* object) const override {
    std::vector<YamlEntry> entries;
    keys_->write(object, entries);
    return yaml_map(entries);
  }

private:
  BoundKeysPtr keys_;
};

}  // namespace

BoundKeysPtr bind_field(const FieldWords& words, const AnyFormPtr& form, Place place,
                        const YamlNodePtr& default_value) {
  return std::make_shared<const FieldKey>(words, form, place, default_value);
}

BoundKeysPtr bind_inlined(const BoundKeysPtr& inner, Place place) {
  return std::make_shared<const InlinedKeys>(inner, place);
}

BoundKeysPtr bind_held(const BoundKeysPtr& fields, const HeldType& type, Place place) {
  return std::make_shared<const HeldKeys>(fields, type, place);
}

BoundKeysPtr bind_one_of(std::vector<std::string> names, std::vector<BoundKeysPtr> cases, bool needed) {
  return std::make_shared<const AlternativeKeys>(std::move(names), std::move(cases), needed);
}

FieldTable::FieldTable() = default;
FieldTable::FieldTable(const FieldTable&) = default;
FieldTable::~FieldTable() = default;

BoundKeysPtr FieldTable::bound_keys() const { return std::make_shared<const AllKeys>(fields_, checks_); }

void FieldTable::add(BoundKeysPtr keys) { fields_.push_back(std::move(keys)); }
void FieldTable::add(Check check) { checks_.push_back(std::move(check)); }

AnyFormPtr map_form(const BoundKeysPtr& keys) { return std::make_shared<const MapForm>(keys); }

}  // namespace kalfem
