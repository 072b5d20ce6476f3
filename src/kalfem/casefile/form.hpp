#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/base/units.hpp"
#include "kalfem/casefile/cursor.hpp"
#include "kalfem/casefile/form_schema.hpp"

namespace kalfem {

/// How a T is written in a case file: the one description from which it is read, echoed and documented.
template <class T>
struct Form {
  using Value = T;

  /// Nothing when the value is not usable; then an issue was added.
  std::function<std::optional<T>(const Cursor&)> read;
  std::function<YamlNodePtr(const T&)> write;
  FormSchema schema;

  [[nodiscard]] std::string written() const { return schema.written(); }
};

/// Named values in file order.
template <class T>
using Named = std::vector<std::pair<std::string, T>>;

/// A value and where it was given, for problems that show only when the parts of a case are put together.
template <class T>
struct Located {
  T value{};
  SourceLocation location{};
  std::string path{};

  /// An issue about the value, with its place.
  [[nodiscard]] Issue issue(const std::string& what, std::string why = {}, std::string fix = {}) const {
    return {location, path + ": " + what, std::move(why), std::move(fix)};
  }
  /// Equal values; the place does not matter.
  bool operator==(const Located& other) const { return value == other.value; }
};

/// The numbers that are accepted: low <= x <= high, or < where the end is open.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  static Bounds any() { return {}; }
  static Bounds positive() { return {.low = 0.0, .low_open = true}; }
  static Bounds nonnegative() { return {.low = 0.0}; }
  static Bounds between(double low, double high) { return {.low = low, .high = high}; }

  [[nodiscard]] bool contain(double x) const;
  /// "> 0", "in [0, 1]" ..., "" when every number is accepted.
  [[nodiscard]] std::string describe() const;
};

/// The value in SI when the unit and the bounds fit; throws InvalidInput.
double checked_number(const std::string& text, const std::string& unit, const Bounds& bounds);
/// As above for a quantity whose unit was not known when it was read; throws InvalidInput with its place.
double checked_number(const Located<Quantity>& given, const std::string& unit, const Bounds& bounds = {});

/// The names of a named map: part of a dotted path (letters, digits, _ and -), or such a path ("suspension.k").
enum class NameRule { name, dotted };
/// Throws InvalidInput when the name does not follow the rule.
void require_name(const std::string& name, NameRule rule);

/// A word for a value of an enumeration; both texts are literals, which outlive every form.
template <class T>
struct Choice {
  std::string_view word;
  T value;
  std::string_view meaning{};
};

/// Forms, combined freely: list(number("Hz")), named(mapping(fields)).
namespace form {

/// A scalar with a parser and a writer of its own; `parse` throws InvalidInput, `written` says what is expected. Set
/// `literal` when the text is a number or a word of yours, so that it is echoed without quotes.
template <class T>
Form<T> scalar(const std::string& written, std::function<T(const std::string&)> parse,
               std::function<std::string(const T&)> print, bool literal = false) {
  const auto read = [=](const Cursor& cursor) -> std::optional<T> {
    if (!cursor.require(YamlNode::Kind::scalar, written)) return std::nullopt;
    try {
      return parse(cursor.node().text);
    } catch (const InvalidInput& error) {
      cursor.issue(error);
      return std::nullopt;
    }
  };
  const auto write = [=](const T& value) { return literal ? yaml_literal(print(value)) : yaml_text(print(value)); };
  return {read, write, scalar_schema(written)};
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

/// Throws InvalidInput for a word that is none of the known ones.
[[noreturn]] void refuse_word(const std::string& word, const std::vector<std::string>& known, const FormSchema& schema);

/// One of a few words.
template <class T>
Form<T> choice(const std::vector<Choice<T>>& choices) {
  std::vector<std::string> words, meanings;
  for (const auto& each : choices) {
    words.emplace_back(each.word);
    meanings.emplace_back(each.meaning);
  }
  const FormSchema schema = choice_schema(words, meanings);
  const auto parse = [=](const std::string& word) -> T {
    for (const auto& each : choices)
      if (each.word == word) return each.value;
    refuse_word(word, words, schema);
  };
  const auto print = [=](const T& value) {
    const auto found =
        std::find_if(choices.begin(), choices.end(), [&](const auto& each) { return each.value == value; });
    return found == choices.end() ? std::string() : std::string(found->word);
  };
  auto form = scalar<T>(schema.written(), parse, print);
  form.schema = schema;
  return form;
}

/// A word out of names that are known at run time (laws, filters of a registry).
Form<std::string> word(const std::vector<std::string>& known);

/// Whether the list has so many values; otherwise adds an issue.
bool require_size(const Cursor& list, std::size_t least, std::size_t most);

/// A list of any length.
template <class T>
Form<std::vector<T>> list(const Form<T>& item, std::size_t least = 0,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const FormSchema schema = list_schema(item.schema, least, most);
  const auto read = [=](const Cursor& cursor) -> std::optional<std::vector<T>> {
    if (!cursor.require(YamlNode::Kind::list, schema.written())) return std::nullopt;
    const std::size_t size = cursor.node().items.size();
    if (!require_size(cursor, least, most)) return std::nullopt;
    std::vector<T> values;
    for (std::size_t i = 0; i < size; ++i)
      if (auto value = item.read(cursor.item(i))) values.push_back(std::move(*value));
    if (values.size() != size) return std::nullopt;
    return values;
  };
  const auto write = [=](const std::vector<T>& values) {
    std::vector<YamlNodePtr> items;
    for (const auto& value : values) items.push_back(item.write(value));
    return yaml_list(items, item.schema.unit());
  };
  return {read, write, schema};
}

/// Exactly N values, such as a band or a point.
template <std::size_t N, class T>
Form<std::array<T, N>> tuple(const Form<T>& item) {
  const auto values = list(item, N, N);
  const auto read = [=](const Cursor& cursor) -> std::optional<std::array<T, N>> {
    const auto given = values.read(cursor);
    if (!given) return std::nullopt;
    std::array<T, N> array;
    std::copy(given->begin(), given->end(), array.begin());
    return array;
  };
  const auto write = [=](const std::array<T, N>& array) { return values.write({array.begin(), array.end()}); };
  return {read, write, values.schema.written_as("list of " + std::to_string(N) + ": " + item.written())};
}

/// A form and a shorter one for the same thing: `modal: 1 %` for `modal: [1 %]`. The short form is the one taken for a
/// scalar; the full form is echoed.
template <class T>
Form<T> either(const Form<T>& short_form, const Form<T>& full_form) {
  const auto read = [=](const Cursor& cursor) {
    return cursor.node().kind == YamlNode::Kind::scalar ? short_form.read(cursor) : full_form.read(cursor);
  };
  return {read, full_form.write, either_schema(short_form.schema, full_form.schema)};
}

/// Another C++ type for the same text: `to` after reading (throws InvalidInput when it cannot be), `from` before
/// writing.
template <class U, class T>
Form<U> convert(const Form<T>& form, std::function<U(const T&)> to, std::function<T(const U&)> from) {
  const auto read = [=](const Cursor& cursor) -> std::optional<U> {
    const auto value = form.read(cursor);
    if (!value) return std::nullopt;
    try {
      return to(*value);
    } catch (const InvalidInput& error) {
      cursor.issue(error);
      return std::nullopt;
    }
  };
  return {read, [=](const U& value) { return form.write(from(value)); }, form.schema};
}

/// One value or a list of them.
template <class T>
Form<std::vector<T>> one_or_list(const Form<T>& item) {
  const Form<std::vector<T>> several = list(item);
  const auto read = [=](const Cursor& cursor) -> std::optional<std::vector<T>> {
    if (cursor.node().kind == YamlNode::Kind::list) return several.read(cursor);
    auto value = item.read(cursor);
    if (!value) return std::nullopt;
    return std::vector<T>{std::move(*value)};
  };
  return {read, several.write, either_schema(item.schema, several.schema)};
}

/// A map from names that the user chooses, in file order.
template <class T>
Form<Named<T>> named(const Form<T>& item, NameRule rule = NameRule::name) {
  const FormSchema schema = named_schema(item.schema);
  const auto read = [=](const Cursor& cursor) -> std::optional<Named<T>> {
    if (!cursor.require(YamlNode::Kind::map, schema.written())) return std::nullopt;
    const std::size_t before = cursor.issue_count();
    Named<T> values;
    for (const auto& entry : cursor.node().entries) {
      const Cursor child = cursor.at(entry);
      try {
        require_name(entry.key, rule);
      } catch (const InvalidInput& error) {
        child.issue(error);
      }
      if (auto value = item.read(child)) values.emplace_back(entry.key, std::move(*value));
    }
    if (cursor.issue_count() != before) return std::nullopt;
    return values;
  };
  const auto write = [=](const Named<T>& values) {
    std::vector<YamlEntry> entries;
    for (const auto& [name, value] : values) entries.push_back({name, 0, item.write(value)});
    return yaml_map(entries);
  };
  return {read, write, schema};
}

/// The value with the place where it was given.
template <class T>
Form<Located<T>> located(const Form<T>& form) {
  const auto read = [=](const Cursor& cursor) -> std::optional<Located<T>> {
    auto value = form.read(cursor);
    if (!value) return std::nullopt;
    return Located<T>{std::move(*value), cursor.location(), cursor.path()};
  };
  return {read, [=](const Located<T>& located) { return form.write(located.value); }, form.schema};
}

}  // namespace form
}  // namespace kalfem
