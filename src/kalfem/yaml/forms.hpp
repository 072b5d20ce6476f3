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
#include "kalfem/yaml/form.hpp"

namespace kalfem {

/// The names of a named map: part of a dotted path (letters, digits, _ and -), or such a path ("suspension.k").
enum class NameRule { name, dotted };
/// Throws InvalidInput when the name does not follow the rule.
void require_name(const std::string& name, NameRule rule);

/// A word for a value of an enumeration.
template <class T>
struct Choice {
  std::string_view word;
  T value;
  std::string_view meaning{};
};

/// Forms, combined freely: list(number("Hz")), named(mapping(fields)).
namespace form {

/// A scalar with a parser T parse(const std::string&), which throws InvalidInput, and a writer YamlNodePtr write(const
/// T&).
template <class T, class Parse, class Write>
Form<T> scalar(FormSchema schema, Parse parse, Write write) {
  const auto read = [parse = std::move(parse), schema](const Cursor& cursor, T& value) {
    if (!cursor.require(YamlNode::Kind::scalar, schema.written())) return false;
    try {
      value = parse(cursor.node().text);
      return true;
    } catch (const InvalidInput& error) {
      cursor.issue(error);
      return false;
    }
  };
  return make_form<T>(read, std::move(write), std::move(schema));
}

/// A number with a unit; a bare one is SI.
Form<double> number(std::string_view unit, const Bounds& bounds = {});
/// A whole number.
Form<int> integer(int low = std::numeric_limits<int>::min(), int high = std::numeric_limits<int>::max());
/// A seed: a whole number from 0 to 2^64 - 1.
Form<std::uint64_t> seed();
Form<bool> boolean();
Form<std::string> text();
/// A number with any unit, which is checked later by checked_number().
Form<Quantity> quantity();
/// A path relative to the case file; becomes absolute. `existing` files must be there.
Form<std::filesystem::path> path(bool existing = true);
/// A word out of names that are known at run time (laws, filters of a registry).
Form<std::string> word(const std::vector<std::string>& known);
/// One of a few words, by its number among them.
Form<std::size_t> one_of_words(const std::vector<std::string>& words, const std::vector<std::string>& meanings);

/// The same in other words.
AnyFormPtr restated(const AnyFormPtr& form, const std::string& words);
template <class T>
Form<T> written_as(const std::string& words, const Form<T>& form) {
  return Form<T>(restated(form.any(), words));
}

/// A form and a shorter one for the same thing: `modal: 1 %` for `modal: [1 %]`. The short form is the one taken for a
/// scalar; the full form is echoed.
AnyFormPtr short_or_full(const AnyFormPtr& short_form, const AnyFormPtr& full_form);
template <class T>
Form<T> either(const Form<T>& short_form, const Form<T>& full_form) {
  return Form<T>(short_or_full(short_form.any(), full_form.any()));
}

/// One of a few words.
template <class T>
Form<T> choice(const std::vector<Choice<T>>& choices) {
  std::vector<std::string> words, meanings;
  std::vector<T> values;
  for (const auto& each : choices) {
    words.emplace_back(each.word);
    meanings.emplace_back(each.meaning);
    values.push_back(each.value);
  }
  const Form<std::size_t> number = one_of_words(words, meanings);
  const auto read = [=](const Cursor& cursor, T& value) {
    std::size_t chosen = 0;
    if (!number.read(cursor, chosen)) return false;
    value = values[chosen];
    return true;
  };
  const auto write = [=](const T& value) {
    return number.write(static_cast<std::size_t>(std::find(values.begin(), values.end(), value) - values.begin()));
  };
  return make_form<T>(read, write, number.schema());
}

/// Whether the list has so many values; otherwise adds an issue.
bool require_size(const Cursor& list, std::size_t least, std::size_t most);

/// A list of any length.
template <class T>
Form<std::vector<T>> list(const Form<T>& item, std::size_t least = 0,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const FormSchema schema = list_schema(item.schema(), least, most);
  const auto read = [=](const Cursor& cursor, std::vector<T>& values) {
    if (!cursor.require(YamlNode::Kind::list, schema.written())) return false;
    if (!require_size(cursor, least, most)) return false;
    values.assign(cursor.node().items.size(), T{});
    bool usable = true;
    for (std::size_t i = 0; i < values.size(); ++i) usable = item.read(cursor.item(i), values[i]) && usable;
    return usable;
  };
  const auto write = [=](const std::vector<T>& values) {
    std::vector<YamlNodePtr> items;
    for (const auto& value : values) items.push_back(item.write(value));
    return yaml_list(items, item.schema().unit());
  };
  return make_form<std::vector<T>>(read, write, schema);
}

/// Exactly N values, such as a band or a point.
template <std::size_t N, class T>
Form<std::array<T, N>> tuple(const Form<T>& item) {
  const auto values = list(item, N, N);
  const auto read = [=](const Cursor& cursor, std::array<T, N>& array) {
    std::vector<T> given;
    if (!values.read(cursor, given)) return false;
    std::copy(given.begin(), given.end(), array.begin());
    return true;
  };
  const auto write = [=](const std::array<T, N>& array) { return values.write({array.begin(), array.end()}); };
  return make_form<std::array<T, N>>(
      read, write, values.schema().written_as("list of " + std::to_string(N) + ": " + item.written()));
}

/// Another C++ type for the same text: `to` after reading (throws InvalidInput when it cannot be), `from` before
/// writing.
template <class U, class T, class To, class From>
Form<U> convert(const Form<T>& form, To to, From from) {
  const auto read = [=](const Cursor& cursor, U& value) {
    T given{};
    if (!form.read(cursor, given)) return false;
    try {
      value = to(given);
      return true;
    } catch (const InvalidInput& error) {
      cursor.issue(error);
      return false;
    }
  };
  return make_form<U>(
      read, [=](const U& value) { return form.write(from(value)); }, form.schema());
}

/// One value or a list of them.
template <class T>
Form<std::vector<T>> one_or_list(const Form<T>& item) {
  const Form<std::vector<T>> several = list(item);
  const auto read = [=](const Cursor& cursor, std::vector<T>& values) {
    if (cursor.node().kind == YamlNode::Kind::list) return several.read(cursor, values);
    values.assign(1, T{});
    return item.read(cursor, values.front());
  };
  return make_form<std::vector<T>>(
      read, [=](const std::vector<T>& values) { return several.write(values); },
      either_schema(item.schema(), several.schema()));
}

/// A map from names that the user chooses, in file order.
template <class T>
Form<Named<T>> named(const Form<T>& item, NameRule rule = NameRule::name) {
  const FormSchema schema = named_schema(item.schema());
  const auto read = [=](const Cursor& cursor, Named<T>& values) {
    if (!cursor.require(YamlNode::Kind::map, schema.written())) return false;
    const std::size_t before = cursor.issue_count();
    values.clear();
    for (const auto& entry : cursor.node().entries) {
      const Cursor child = cursor.at(entry);
      try {
        require_name(entry.key, rule);
      } catch (const InvalidInput& error) {
        child.issue(error);
      }
      item.read(child, values.emplace_back(entry.key, T{}).second);
    }
    return cursor.issue_count() == before;
  };
  const auto write = [=](const Named<T>& values) {
    std::vector<YamlEntry> entries;
    for (const auto& [name, value] : values) entries.push_back({name, 0, item.write(value)});
    return yaml_map(entries);
  };
  return make_form<Named<T>>(read, write, schema);
}

/// The value with the place where it was given.
template <class T>
Form<Located<T>> located(const Form<T>& form) {
  const auto read = [=](const Cursor& cursor, Located<T>& located) {
    located.location = cursor.location();
    located.path = cursor.path();
    return form.read(cursor, located.value);
  };
  return make_form<Located<T>>(
      read, [=](const Located<T>& located) { return form.write(located.value); }, form.schema());
}

}  // namespace form
}  // namespace kalfem
