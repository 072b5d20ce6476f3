#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/base/units.hpp"
#include "kalfem/casefile/cursor.hpp"
#include "kalfem/casefile/form_schema.hpp"

namespace kalfem {

/// How a value is written in a case file: the one description from which it is read, echoed and documented. The type of
/// the value is known only to those who made the form: what all maps have in common is so compiled once (fields.cpp).
/// Immutable.
class AnyForm {
public:
  explicit AnyForm(FormSchema schema) : schema(std::move(schema)) {}
  AnyForm(const AnyForm&) = delete;
  AnyForm& operator=(const AnyForm&) = delete;
  virtual ~AnyForm() = default;

  /// Leaves the value as it is where the text is not usable; then an issue was added.
  virtual void read_into(const Cursor& cursor, void* value) const = 0;
  /// Null for an empty value.
  virtual YamlNodePtr write_from(const void* value) const = 0;

  const FormSchema schema;
};

using AnyFormPtr = std::shared_ptr<const AnyForm>;

/// The form of a T.
template <class T>
class FormOf : public AnyForm {
public:
  using AnyForm::AnyForm;

  virtual std::optional<T> read(const Cursor& cursor) const = 0;
  virtual YamlNodePtr write(const T& value) const = 0;

  void read_into(const Cursor& cursor, void* value) const override {
    if (auto given = read(cursor)) *static_cast<T*>(value) = std::move(*given);
  }
  YamlNodePtr write_from(const void* value) const override { return write(*static_cast<const T*>(value)); }
};

/// A form of a T, shared by all copies.
template <class T>
class Form {
public:
  using Value = T;

  explicit Form(std::shared_ptr<const FormOf<T>> form) : form_(std::move(form)) {}

  /// Nothing when the value is not usable; then an issue was added.
  [[nodiscard]] std::optional<T> read(const Cursor& cursor) const { return form_->read(cursor); }
  [[nodiscard]] YamlNodePtr write(const T& value) const { return form_->write(value); }
  [[nodiscard]] const FormSchema& schema() const { return form_->schema; }
  [[nodiscard]] std::string written() const { return schema().written(); }
  [[nodiscard]] const std::shared_ptr<const FormOf<T>>& shared() const { return form_; }

private:
  std::shared_ptr<const FormOf<T>> form_;
};

/// The form that reads with std::optional<T> read(const Cursor&) and writes with YamlNodePtr write(const T&).
template <class T, class Read, class Write>
Form<T> make_form(Read read, Write write, FormSchema schema) {
  class Made final : public FormOf<T> {
  public:
    Made(Read read, Write write, FormSchema schema)
        : FormOf<T>(std::move(schema)), read_(std::move(read)), write_(std::move(write)) {}
    std::optional<T> read(const Cursor& cursor) const override { return read_(cursor); }
    YamlNodePtr write(const T& value) const override { return write_(value); }

  private:
    Read read_;
    Write write_;
  };
  return Form<T>(std::make_shared<const Made>(std::move(read), std::move(write), std::move(schema)));
}

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

/// A scalar with a parser T parse(const std::string&), which throws InvalidInput, and a writer YamlNodePtr write(const
/// T&).
template <class T, class Parse, class Write>
Form<T> scalar(FormSchema schema, Parse parse, Write write) {
  const auto read = [parse = std::move(parse), schema](const Cursor& cursor) -> std::optional<T> {
    if (!cursor.require(YamlNode::Kind::scalar, schema.written())) return std::nullopt;
    try {
      return parse(cursor.node().text);
    } catch (const InvalidInput& error) {
      cursor.issue(error);
      return std::nullopt;
    }
  };
  return make_form<T>(read, std::move(write), std::move(schema));
}

/// The same in other words.
template <class T>
Form<T> written_as(const std::string& words, const Form<T>& form) {
  return make_form<T>([form](const Cursor& cursor) { return form.read(cursor); },
                      [form](const T& value) { return form.write(value); }, form.schema().written_as(words));
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

/// One of a few words, by its number among them.
Form<std::size_t> one_of_words(const std::vector<std::string>& words, const std::vector<std::string>& meanings);

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
  const auto read = [=](const Cursor& cursor) -> std::optional<T> {
    const auto chosen = number.read(cursor);
    if (!chosen) return std::nullopt;
    return values[*chosen];
  };
  const auto write = [=](const T& value) {
    return number.write(static_cast<std::size_t>(std::find(values.begin(), values.end(), value) - values.begin()));
  };
  return make_form<T>(read, write, number.schema());
}

/// A word out of names that are known at run time (laws, filters of a registry).
Form<std::string> word(const std::vector<std::string>& known);

/// Whether the list has so many values; otherwise adds an issue.
bool require_size(const Cursor& list, std::size_t least, std::size_t most);

/// A list of any length.
template <class T>
Form<std::vector<T>> list(const Form<T>& item, std::size_t least = 0,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) {
  const FormSchema schema = list_schema(item.schema(), least, most);
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
    return yaml_list(items, item.schema().unit());
  };
  return make_form<std::vector<T>>(read, write, schema);
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
  return make_form<std::array<T, N>>(
      read, write, values.schema().written_as("list of " + std::to_string(N) + ": " + item.written()));
}

/// A form and a shorter one for the same thing: `modal: 1 %` for `modal: [1 %]`. The short form is the one taken for a
/// scalar; the full form is echoed.
template <class T>
Form<T> either(const Form<T>& short_form, const Form<T>& full_form) {
  const auto read = [=](const Cursor& cursor) {
    return cursor.node().kind == YamlNode::Kind::scalar ? short_form.read(cursor) : full_form.read(cursor);
  };
  return make_form<T>(
      read, [=](const T& value) { return full_form.write(value); },
      either_schema(short_form.schema(), full_form.schema()));
}

/// Another C++ type for the same text: `to` after reading (throws InvalidInput when it cannot be), `from` before
/// writing.
template <class U, class T, class To, class From>
Form<U> convert(const Form<T>& form, To to, From from) {
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
  return make_form<U>(
      read, [=](const U& value) { return form.write(from(value)); }, form.schema());
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
  return make_form<std::vector<T>>(
      read, [=](const std::vector<T>& values) { return several.write(values); },
      either_schema(item.schema(), several.schema()));
}

/// A map from names that the user chooses, in file order.
template <class T>
Form<Named<T>> named(const Form<T>& item, NameRule rule = NameRule::name) {
  const FormSchema schema = named_schema(item.schema());
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
  return make_form<Named<T>>(read, write, schema);
}

/// The value with the place where it was given.
template <class T>
Form<Located<T>> located(const Form<T>& form) {
  const auto read = [=](const Cursor& cursor) -> std::optional<Located<T>> {
    auto value = form.read(cursor);
    if (!value) return std::nullopt;
    return Located<T>{std::move(*value), cursor.location(), cursor.path()};
  };
  return make_form<Located<T>>(
      read, [=](const Located<T>& located) { return form.write(located.value); }, form.schema());
}

}  // namespace form
}  // namespace kalfem
