// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/units.hpp"
#include "kalfem/yaml/bounds.hpp"
#include "kalfem/yaml/schema.hpp"

namespace kalfem {

/// The names of a named map: part of a dotted path (letters, digits, _ and -), or such a path ("suspension.k").
enum class NameRule { name, dotted };
/// Throws InvalidInput if the name breaks the rule.
void require_name(const std::string& name, NameRule rule);

/// A word for a value of an enumeration.
template <class T>
struct Choice {
  std::string_view word;
  T value;
  std::string_view meaning{};
};

/// Schemas of single values and ways to combine them: list(number("Hz")), named(mapping(fields)).
namespace schema {

/// A scalar with a parser T parse(const std::string&), which throws InvalidInput, and a writer YamlNodePtr write(const
/// T&).
template <class T, class Parse, class Write>
Schema<T> scalar(JsonSchema json_schema, Parse parse, Write write) {
  const auto read = [parse = std::move(parse), json_schema](const CaseNode& node, T& value) {
    if (!node.require(YamlNode::Kind::scalar, json_schema.written())) return false;
    try {
      value = parse(node.yaml().text);
      return true;
    } catch (const InvalidInput& error) {
      node.issue(error);
      return false;
    }
  };
  return make_schema<T>(read, std::move(write), std::move(json_schema));
}

/// A number with a unit; a bare one is SI.
Schema<double> number(std::string_view unit, const Bounds& bounds = {});
/// A whole number.
Schema<int> integer(int low = std::numeric_limits<int>::min(), int high = std::numeric_limits<int>::max());
/// A seed: a whole number from 0 to 2^64 - 1.
Schema<std::uint64_t> seed();
Schema<bool> boolean();
Schema<std::string> text();
/// A number with any unit, which is checked later by checked_number().
Schema<Quantity> quantity();
/// A path relative to the case file; becomes absolute. `existing` files must be there.
Schema<std::filesystem::path> path(bool existing = true);
/// One of several names that are known at run time, such as connector laws.
Schema<std::string> word(const std::vector<std::string>& known);
/// One of a few words, by its number among them.
Schema<std::size_t> one_of_words(const std::vector<std::string>& words, const std::vector<std::string>& meanings);

/// The same schema, described by other words.
AnySchemaPtr restated(const AnySchemaPtr& schema, const std::string& words);
template <class T>
Schema<T> written_as(const std::string& words, const Schema<T>& schema) {
  return Schema<T>(restated(schema.any(), words));
}

/// A schema and a shorter one for the same thing: `modal: 1 %` for `modal: [1 %]`. The short schema is the one taken
/// for a scalar; the full schema is echoed.
AnySchemaPtr short_or_full(const AnySchemaPtr& short_schema, const AnySchemaPtr& full_schema);
template <class T>
Schema<T> either(const Schema<T>& short_schema, const Schema<T>& full_schema) {
  return Schema<T>(short_or_full(short_schema.any(), full_schema.any()));
}

/// One of a few words.
template <class T>
Schema<T> choice(const std::vector<Choice<T>>& choices) {
  std::vector<std::string> words, meanings;
  std::vector<T> values;
  for (const auto& each : choices) {
    words.emplace_back(each.word);
    meanings.emplace_back(each.meaning);
    values.push_back(each.value);
  }
  const Schema<std::size_t> number = one_of_words(words, meanings);
  const auto read = [=](const CaseNode& node, T& value) {
    std::size_t chosen = 0;
    if (!number.read(node, chosen)) return false;
    value = values[chosen];
    return true;
  };
  const auto write = [=](const T& value) {
    return number.write(static_cast<std::size_t>(std::find(values.begin(), values.end(), value) - values.begin()));
  };
  return make_schema<T>(read, write, number.json_schema());
}

/// Whether the list has so many values; otherwise adds an issue.
bool require_size(const CaseNode& list, std::size_t least, std::size_t most);

/// A list of any length.
template <class T>
Schema<std::vector<T>> list(const Schema<T>& item, std::size_t least = 0,
                            std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const JsonSchema json_schema = list_schema(item.json_schema(), least, most);
  const auto read = [=](const CaseNode& node, std::vector<T>& values) {
    if (!node.require(YamlNode::Kind::list, json_schema.written())) return false;
    if (!require_size(node, least, most)) return false;
    values.assign(node.yaml().items.size(), T{});
    bool usable = true;
    for (std::size_t i = 0; i < values.size(); ++i) usable = item.read(node.item(i), values[i]) && usable;
    return usable;
  };
  const auto write = [=](const std::vector<T>& values) {
    std::vector<YamlNodePtr> items;
    for (const auto& value : values) items.push_back(item.write(value));
    return yaml_list(items, item.json_schema().unit());
  };
  return make_schema<std::vector<T>>(read, write, json_schema);
}

/// Exactly N values, such as a band or a point.
template <std::size_t N, class T>
Schema<std::array<T, N>> tuple(const Schema<T>& item) {
  const auto values = list(item, N, N);
  const auto read = [=](const CaseNode& node, std::array<T, N>& array) {
    std::vector<T> given;
    if (!values.read(node, given)) return false;
    std::copy(given.begin(), given.end(), array.begin());
    return true;
  };
  const auto write = [=](const std::array<T, N>& array) { return values.write({array.begin(), array.end()}); };
  return make_schema<std::array<T, N>>(
      read, write, values.json_schema().written_as("list of " + std::to_string(N) + ": " + item.written()));
}

/// Another C++ type for the same text. `to` converts after reading and may throw InvalidInput; `from` converts before
/// writing.
template <class U, class T, class To, class From>
Schema<U> convert(const Schema<T>& schema, To to, From from) {
  const auto read = [=](const CaseNode& node, U& value) {
    T given{};
    if (!schema.read(node, given)) return false;
    try {
      value = to(given);
      return true;
    } catch (const InvalidInput& error) {
      node.issue(error);
      return false;
    }
  };
  return make_schema<U>(
      read, [=](const U& value) { return schema.write(from(value)); }, schema.json_schema());
}

/// One value or a list of them.
template <class T>
Schema<std::vector<T>> one_or_list(const Schema<T>& item) {
  const Schema<std::vector<T>> several = list(item);
  const auto read = [=](const CaseNode& node, std::vector<T>& values) {
    if (node.yaml().kind == YamlNode::Kind::list) return several.read(node, values);
    values.assign(1, T{});
    return item.read(node, values.front());
  };
  return make_schema<std::vector<T>>(
      read, [=](const std::vector<T>& values) { return several.write(values); },
      either_schema(item.json_schema(), several.json_schema()));
}

/// A map from names that the user chooses, in file order.
template <class T>
Schema<Named<T>> named(const Schema<T>& item, NameRule rule = NameRule::name) {
  const JsonSchema json_schema = named_schema(item.json_schema());
  const auto read = [=](const CaseNode& node, Named<T>& values) {
    if (!node.require(YamlNode::Kind::map, json_schema.written())) return false;
    const std::size_t before = node.issue_count();
    values.clear();
    for (const auto& entry : node.yaml().entries) {
      const CaseNode child = node.at(entry);
      try {
        require_name(entry.key, rule);
      } catch (const InvalidInput& error) {
        child.issue(error);
      }
      item.read(child, values.emplace_back(entry.key, T{}).second);
    }
    return node.issue_count() == before;
  };
  const auto write = [=](const Named<T>& values) {
    std::vector<YamlEntry> entries;
    for (const auto& [name, value] : values) entries.push_back({name, 0, item.write(value)});
    return yaml_map(entries);
  };
  return make_schema<Named<T>>(read, write, json_schema);
}

/// The value with its place in the file.
template <class T>
Schema<Located<T>> located(const Schema<T>& schema) {
  const auto read = [=](const CaseNode& node, Located<T>& located) {
    located.location = node.location();
    located.path = node.path();
    return schema.read(node, located.value);
  };
  return make_schema<Located<T>>(
      read, [=](const Located<T>& located) { return schema.write(located.value); }, schema.json_schema());
}

}  // namespace schema
}  // namespace kalfem
