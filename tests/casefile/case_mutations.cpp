// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_mutations.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>

namespace kalfem::test {
namespace {

/// Parameters of expressions, and signals that they read, may have any unit.
bool has_any_unit(const std::string& path) {
  return std::ranges::any_of(
      std::array{"maxwell.parameters", "component.parameters", "fed.parameters", "fed.priors", ".signals."},
      [&](const char* part) { return path.find(part) != std::string::npos; });
}

using Json = nlohmann::ordered_json;
using Kind = YamlNode::Kind;
using Place = std::vector<std::size_t>;  ///< numbers of entries and items from the root on

/// The tree with the node at the place changed.
YamlNodePtr changed(const YamlNodePtr& node, const Place& place, std::size_t depth,
                    const std::function<void(YamlNode&)>& change) {
  YamlNode copy = *node;
  if (depth == place.size())
    change(copy);
  else if (copy.kind == Kind::map)
    copy.entries[place[depth]].value = changed(copy.entries[place[depth]].value, place, depth + 1, change);
  else
    copy.items[place[depth]] = changed(copy.items[place[depth]], place, depth + 1, change);
  return std::make_shared<YamlNode>(std::move(copy));
}

YamlNode scalar(const std::string& text) { return *yaml_literal(text); }
YamlNode list_of(const std::string& text) { return *yaml_list({yaml_literal(text)}); }
YamlNode map_of(const std::string& key) { return *yaml_map({{key, 0, yaml_literal("1")}}); }

/// The alternative of a schema that a node is written in.
const Json& written_in(const Json& schema, const YamlNode& node) {
  if (!schema.contains("anyOf")) return schema;
  for (const auto& each : schema["anyOf"]) {
    const Json& alternative = written_in(each, node);
    const Json type = alternative.value("type", Json("scalar"));
    const Kind kind = type == "array" ? Kind::list : type == "object" ? Kind::map : Kind::scalar;
    if (kind == node.kind) return alternative;
  }
  return schema["anyOf"].front();
}

/// Whether the schema allows a list, or a map, somewhere.
bool allows(const Json& schema, const std::string& type) {
  if (schema.value("type", Json()) == type) return true;
  for (const auto& each : schema.value("anyOf", Json::array()))
    if (allows(each, type)) return true;
  return false;
}

/// Whether a map with names that the user chooses is allowed.
bool has_free_names(const Json& schema) {
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) return true;
  const Json alternatives = schema.value("anyOf", Json::array());
  return std::ranges::any_of(alternatives, has_free_names);
}

/// Keys whose text may be anything.
bool is_free_text(const std::string& key) {
  static const std::set<std::string> free{"title", "name",       "channel", "unit",   "columns", "dataset", "grounds",
                                          "state", "write_deck", "broker",  "client", "publish", "topics"};
  return free.contains(key);
}

class Generator {
public:
  Generator(YamlNodePtr root, std::set<std::string>& reached) : root_(std::move(root)), reached_(reached) {}

  void walk(const Json& schema, const YamlNode& node, const Place& place, const std::string& path,
            const std::string& in_schema) {
    const Json& used = written_in(schema, node);
    if (used.contains("properties")) walk_keys(used, node, place, path, in_schema);
    if (used.contains("additionalProperties") && used["additionalProperties"].is_object())
      walk_names(used["additionalProperties"], node, place, path, in_schema);
    if (used.contains("items") && node.kind == Kind::list) walk_items(used, node, place, path, in_schema);
  }

  std::vector<Mutation> take() { return std::move(mutations_); }

private:
  void add(const std::string& path, const std::string& kind, const Place& place,
           const std::function<void(YamlNode&)>& change, bool wrong = true) {
    mutations_.push_back({path, kind, to_yaml(*changed(root_, place, 0, change)), wrong});
  }

  static Place below(Place place, std::size_t index) {
    place.push_back(index);
    return place;
  }

  void walk_keys(const Json& schema, const YamlNode& map, const Place& place, const std::string& path,
                 const std::string& in_schema) {
    const Json required = schema.value("required", Json::array());
    for (const auto& [key, property] : schema["properties"].items()) {
      const std::string own_path = path + "." + key, own_key = in_schema + "." + key;
      reached_.insert(own_key);
      const auto entry = std::ranges::find(map.entries, key, &YamlEntry::key);
      if (entry == map.entries.end()) {
        insert_wrong_types(property, key, place, own_path);
        continue;
      }
      const auto index = static_cast<std::size_t>(entry - map.entries.begin());
      const bool needed = std::ranges::find(required, Json(key)) != required.end();
      if (needed)
        add(own_path, "missing", place,
            [=](YamlNode& node) { node.entries.erase(node.entries.begin() + static_cast<std::ptrdiff_t>(index)); });
      add(own_path, "doubled", place, [=](YamlNode& node) { node.entries.push_back(node.entries[index]); });
      add(own_path, "misspelt key", place, [=](YamlNode& node) { node.entries[index].key += "x"; });
      change_value(property, *entry->value, below(place, index), own_path, key);
      walk(property, *entry->value, below(place, index), own_path, own_key);
    }
  }

  void insert_wrong_types(const Json& property, const std::string& key, const Place& place, const std::string& path) {
    const auto insert = [&](const YamlNode& value) {
      const auto shared = std::make_shared<YamlNode>(value);
      add(path, "wrong type in a key that was left out", place, [=](YamlNode& node) {
        node.entries.push_back({key, 0, shared});
      });
    };
    if (!allows(property, "object")) insert(map_of("zz"));
    if (!allows(property, "array")) insert(list_of("zz"));
  }

  void walk_names(const Json& item, const YamlNode& map, const Place& place, const std::string& path,
                  const std::string& in_schema) {
    for (std::size_t i = 0; i < map.entries.size(); ++i) {
      const auto& entry = map.entries[i];
      const std::string own_path = path + "." + entry.key;
      add(own_path, "bad name", place, [=](YamlNode& node) { node.entries[i].key = wrong_names[0]; });
      add(own_path, "doubled", place, [=](YamlNode& node) { node.entries.push_back(node.entries[i]); });
      add(
          own_path, "unknown name", place, [=](YamlNode& node) { node.entries[i].key = wrong_names[1]; }, false);
      change_value(item, *entry.value, below(place, i), own_path, "<name>");
      walk(item, *entry.value, below(place, i), own_path, in_schema + ".<name>");
    }
  }

  void walk_items(const Json& schema, const YamlNode& list, const Place& place, const std::string& path,
                  const std::string& in_schema) {
    if (schema.contains("minItems"))
      add(
          path, "too few items", place, [](YamlNode& node) { node.items.pop_back(); },
          list.items.size() <= schema["minItems"]);
    if (schema.contains("maxItems"))
      add(path, "too many items", place, [](YamlNode& node) { node.items.push_back(node.items.back()); });
    for (std::size_t i = 0; i < list.items.size(); ++i) {
      const std::string own_path = path + "[" + std::to_string(i) + "]";
      change_value(schema["items"], *list.items[i], below(place, i), own_path, path.substr(path.rfind('.') + 1));
      walk(schema["items"], *list.items[i], below(place, i), own_path, in_schema);
    }
  }

  /// Every wrong value that the schema of one key suggests.
  void change_value(const Json& property, const YamlNode& node, const Place& place, const std::string& path,
                    const std::string& key) {
    const auto set = [&](const std::string& kind, const YamlNode& value, bool wrong = true) {
      add(
          path, kind, place, [=](YamlNode& changed_node) { changed_node = value; }, wrong);
    };
    const Json& schema = written_in(property, node);
    const bool map = allows(property, "object"), list = allows(property, "array");
    if (!map) set("wrong type: a map", map_of("zz"));
    if (!list) set("wrong type: a list", list_of("zz"));
    if (map) set("wrong type: an unknown key", map_of("zz"), !has_free_names(property));
    set("empty", YamlNode{}, !map);
    if (node.kind != Kind::scalar) return;
    const Json type = schema.value("type", Json());
    if (schema.contains("oneOf")) {
      set("misspelt word", scalar(node.text + "x"));
      set("wrong word", scalar("zzz"));
    } else if (type == "boolean") {
      set("not true or false", scalar("yes"));
    } else if (type == "integer") {
      for (const char* text : {"2.5", "abc", "nan", "1e400", "3 kg"}) set("not a whole number", scalar(text));
      out_of_range(schema, set);
    } else if (type == Json({"number", "string"})) {
      for (const char* text : {"nan", ".inf", "1e400", "abc", "''"}) set("not a number", scalar(text));
      set("wrong unit", scalar("3 K"));
      out_of_range(schema, set);
    } else if (schema.value("x-written", "") == "number with its unit") {
      for (const char* text : {"nan", ".inf", "1e400", "abc"}) set("not a number", scalar(text));
      set("wrong unit", scalar("3 K"), !has_any_unit(path));
    } else {
      set("unknown word", scalar(wrong_names[2]), !is_free_text(key));
    }
  }

  template <class Set>
  static void out_of_range(const Json& schema, const Set& set) {
    const auto number = [](double value) { return scalar(Json(value).dump()); };
    const auto whole = [&](const Json& value) {
      return value.is_number_integer() ? scalar(value.dump()) : number(value);
    };
    if (schema.contains("minimum")) {
      const Json& least = schema["minimum"];
      if (least.is_number_integer())
        set("too small", scalar(std::to_string(least.get<long long>() - 1)));
      else
        set("too small", number(least.get<double>() - std::max(1.0, std::abs(least.get<double>()))));
    }
    if (schema.contains("exclusiveMinimum")) set("too small", whole(schema["exclusiveMinimum"]));
    if (schema.contains("maximum")) {
      const Json& most = schema["maximum"];
      if (most.is_number_integer())
        set("too large", scalar(std::to_string(most.get<long long>() + 1)));
      else
        set("too large", number(1.0 + 2.0 * std::abs(most.get<double>())));
    }
    if (schema.contains("exclusiveMaximum")) set("too large", whole(schema["exclusiveMaximum"]));
  }

  YamlNodePtr root_;
  std::set<std::string>& reached_;
  std::vector<Mutation> mutations_;
};

void collect(const Json& schema, const std::string& path, std::set<std::string>& keys) {
  const Json properties = schema.value("properties", Json::object());
  for (const auto& [key, property] : properties.items()) {
    keys.insert(path + "." + key);
    collect(property, path + "." + key, keys);
  }
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
    collect(schema["additionalProperties"], path + ".<name>", keys);
  if (schema.contains("items")) collect(schema["items"], path, keys);
  for (const auto& each : schema.value("anyOf", Json::array())) collect(each, path, keys);
}

}  // namespace

std::vector<Mutation> mutations_of(const YamlNodePtr& root, const JsonSchema& schema, std::set<std::string>& reached) {
  Generator generator(root, reached);
  generator.walk(schema.json(), *root, {}, "", "");
  return generator.take();
}

std::set<std::string> keys_of(const JsonSchema& schema) {
  std::set<std::string> keys;
  collect(schema.json(), "", keys);
  return keys;
}

}  // namespace kalfem::test
