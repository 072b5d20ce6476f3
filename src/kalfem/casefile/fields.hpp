#pragma once

#include <memory>
#include <variant>

#include "kalfem/casefile/form.hpp"

namespace kalfem {

/// One reading of a map: some of its keys, bound to something of a U.
template <class U>
struct Part {
  std::vector<std::string> keys;
  std::function<void(const Cursor& map, U&)> read;
  std::function<void(const U&, std::vector<YamlEntry>&)> write;
  std::function<void(nlohmann::ordered_json& object)> describe;  ///< adds to properties, required, allOf
};

/// One alternative of Fields::one_of: the kind U that is meant when the map has `key`.
template <class U>
struct Case {
  std::string key;
  Part<U> part;
};

// What does not depend on the types (fields.cpp).
void report_unknown_keys(const Cursor& map, const std::vector<std::string>& known);
void report_missing_key(const Cursor& map, const std::string& key, const std::string& written,
                        const std::string& meaning);
/// Index of the only key that the map has, or nothing; adds an issue for two keys, or for none when one is `needed`.
std::optional<std::size_t> only_key(const Cursor& map, const std::vector<std::string>& keys, bool needed);
/// Issues for the keys of the alternatives that were not chosen.
void report_keys_without_effect(const Cursor& map, const std::vector<std::vector<std::string>>& keys,
                                const std::vector<std::string>& names, std::size_t chosen);
void describe_field(nlohmann::ordered_json& object, const std::string& key, const nlohmann::ordered_json& schema,
                    const std::string& meaning, bool required, const YamlNode* default_value);
void describe_cases(nlohmann::ordered_json& object, const std::vector<nlohmann::ordered_json>& cases,
                    const std::vector<std::string>& names, bool needed);

/// The table that binds the keys of a map to the members of a T, one line a member. From it a case file is read
/// strictly, the resolved case is echoed, and the reference and the JSON Schema are written.
template <class T>
class Fields {
public:
  /// A key that must be there.
  template <class M>
  Fields& required(const std::string& key, M T::*member, const Form<M>& form, const std::string& meaning) {
    return add_field(key, member, form, meaning, true);
  }

  /// A key that may be left out; then the member keeps the default of T{}.
  template <class M>
  Fields& optional(const std::string& key, M T::*member, const Form<M>& form, const std::string& meaning) {
    return add_field(key, member, form, meaning, false);
  }

  /// A key that may be left out; then the member stays empty.
  template <class M>
  Fields& optional(const std::string& key, std::optional<M> T::*member, const Form<M>& form,
                   const std::string& meaning) {
    Part<T> part;
    part.keys = {key};
    part.read = [=](const Cursor& map, T& object) {
      if (const auto* entry = map.node().find(key)) object.*member = form.read(map.at(*entry));
    };
    part.write = [=](const T& object, std::vector<YamlEntry>& entries) {
      if (object.*member) entries.push_back({key, 0, form.write(*(object.*member))});
    };
    part.describe = [=](nlohmann::ordered_json& object) {
      describe_field(object, key, form.schema, meaning, false, nullptr);
    };
    parts_.push_back(std::move(part));
    return *this;
  }

  /// Exactly one of the alternatives when() is there: its key says which type the variant holds. At most one for a
  /// std::optional<std::variant<...>>.
  template <class M, class... U>
  Fields& one_of(M T::*member, const Case<U>&... cases) {
    constexpr bool needed = !requires(M value) { value.reset(); };
    const std::vector<std::string> names{cases.key...};
    const std::vector<std::vector<std::string>> keys{cases.part.keys...};
    Part<T> part;
    for (const auto& each : keys) part.keys.insert(part.keys.end(), each.begin(), each.end());
    part.read = [=](const Cursor& map, T& object) {
      const auto chosen = only_key(map, names, needed);
      if (!chosen) return;
      report_keys_without_effect(map, keys, names, *chosen);
      (read_case(cases, names[*chosen], map, object.*member), ...);
    };
    part.write = [=](const T& object, std::vector<YamlEntry>& entries) {
      (write_case(cases, object.*member, entries), ...);
    };
    part.describe = [=](nlohmann::ordered_json& object) {
      std::vector<nlohmann::ordered_json> schemas(sizeof...(cases));
      std::size_t i = 0;
      (cases.part.describe(schemas[i++]), ...);
      describe_cases(object, schemas, names, needed);
    };
    parts_.push_back(std::move(part));
    return *this;
  }

  /// The fields of a member, in the same map.
  template <class M>
  Fields& inlined(M T::*member, const Fields<M>& fields) {
    const Part<M> inner = fields.as_part();
    parts_.push_back({inner.keys, [=](const Cursor& map, T& object) { inner.read(map, object.*member); },
                      [=](const T& object, std::vector<YamlEntry>& entries) { inner.write(object.*member, entries); },
                      inner.describe});
    return *this;
  }

  /// Requirements that several members meet together; called when each of them is right.
  Fields& check(std::function<std::vector<Issue>(const T&)> validate) {
    checks_.push_back(std::move(validate));
    return *this;
  }

  [[nodiscard]] std::vector<std::string> keys() const {
    std::vector<std::string> all;
    for (const auto& part : parts_) all.insert(all.end(), part.keys.begin(), part.keys.end());
    return all;
  }

  /// All fields as one part of a larger map; keys that are not known are left to the owner of the map.
  [[nodiscard]] Part<T> as_part() const {
    const auto self = std::make_shared<const Fields>(*this);
    return {keys(), [=](const Cursor& map, T& object) { self->read(map, object); },
            [=](const T& object, std::vector<YamlEntry>& entries) {
              for (const auto& part : self->parts_) part.write(object, entries);
            },
            [=](nlohmann::ordered_json& object) {
              for (const auto& part : self->parts_) part.describe(object);
            }};
  }

private:
  template <class M>
  Fields& add_field(const std::string& key, M T::*member, const Form<M>& form, const std::string& meaning,
                    bool required) {
    Part<T> part;
    part.keys = {key};
    part.read = [=](const Cursor& map, T& object) {
      const auto* entry = map.node().find(key);
      if (!entry && required) report_missing_key(map, key, form.written(), meaning);
      if (!entry) return;
      if (auto value = form.read(map.at(*entry))) object.*member = std::move(*value);
    };
    part.write = [=](const T& object, std::vector<YamlEntry>& entries) {
      entries.push_back({key, 0, form.write(object.*member)});
    };
    part.describe = [=](nlohmann::ordered_json& object) {
      const YamlNodePtr default_value = required ? nullptr : form.write(T{}.*member);
      describe_field(object, key, form.schema, meaning, required, default_value.get());
    };
    parts_.push_back(std::move(part));
    return *this;
  }

  template <class U, class M>
  static void read_case(const Case<U>& alternative, const std::string& chosen, const Cursor& map, M& member) {
    if (alternative.key != chosen) return;
    U value{};
    alternative.part.read(map, value);
    member = std::move(value);
  }

  template <class U, class M>
  static void write_case(const Case<U>& alternative, const M& member, std::vector<YamlEntry>& entries) {
    if constexpr (requires { member.has_value(); }) {
      if (member) write_case(alternative, *member, entries);
    } else if (const auto* value = std::get_if<U>(&member)) {
      alternative.part.write(*value, entries);
    }
  }

  void read(const Cursor& map, T& object) const {
    const std::size_t before = map.issue_count();
    for (const auto& part : parts_) part.read(map, object);
    if (map.issue_count() != before) return;
    for (const auto& validate : checks_)
      if (const auto issues = validate(object); !issues.empty()) map.issue(InvalidInput(issues));
  }

  std::vector<Part<T>> parts_;
  std::vector<std::function<std::vector<Issue>(const T&)>> checks_;
};

/// The alternative `key: ...` whose value is written in the given form:  random: {rms: 3 mm, band: [0.5, 30]}.
template <class U>
Case<U> when(const std::string& key, const Form<U>& form, const std::string& meaning) {
  struct Holder {
    U value{};
  };
  const Part<Holder> part = Fields<Holder>().required(key, &Holder::value, form, meaning).as_part();
  return {key,
          {part.keys,
           [=](const Cursor& map, U& value) {
             Holder holder;
             part.read(map, holder);
             value = std::move(holder.value);
           },
           [=](const U& value, std::vector<YamlEntry>& entries) { part.write({value}, entries); }, part.describe}};
}

/// The alternative whose fields stand beside one another in the map; the first key selects it:  file: road.csv,
/// channel: r1.
template <class U>
Case<U> when(const Fields<U>& fields) {
  return {fields.keys().front(), fields.as_part()};
}

namespace form {

/// A map with the given fields and no other keys; nothing after the colon is an empty map.
template <class T>
Form<T> mapping(const Fields<T>& fields) {
  const Part<T> part = fields.as_part();
  std::string written;
  for (const auto& key : part.keys) written += (written.empty() ? "" : ", ") + key;
  written = "{" + written + "}";

  const auto read = [=](const Cursor& cursor) -> std::optional<T> {
    if (cursor.node().kind != YamlNode::Kind::null && !cursor.require(YamlNode::Kind::map, written))
      return std::nullopt;
    const std::size_t before = cursor.issue_count();
    T object{};
    report_unknown_keys(cursor, part.keys);
    part.read(cursor, object);
    if (cursor.issue_count() != before) return std::nullopt;
    return object;
  };
  const auto write = [=](const T& object) {
    std::vector<YamlEntry> entries;
    part.write(object, entries);
    return yaml_map(entries);
  };
  nlohmann::ordered_json schema{{"type", "object"}, {"additionalProperties", false}, {"x-written", written}};
  part.describe(schema);
  return {read, write, schema};
}

}  // namespace form
}  // namespace kalfem
