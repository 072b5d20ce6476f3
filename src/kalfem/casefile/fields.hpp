#pragma once

#include <memory>
#include <variant>

#include "kalfem/casefile/form.hpp"

namespace kalfem {

/// Some keys of a map, bound to an object whose type only the Fields know that made it: everything that maps have in
/// common is so compiled once (fields.cpp).
struct BoundKeys {
  std::vector<std::string> keys;
  std::function<void(const Cursor& map, void* object)> read;
  std::function<void(const void* object, std::vector<YamlEntry>& entries)> write;
  std::function<void(nlohmann::ordered_json& schema)>
      describe;  ///< adds to properties, required and allOf of the map's
};

/// A key in words.
struct FieldWords {
  std::string key, meaning;
  bool required = false;
};

/// One alternative of Fields::one_of: the kind U that is meant when the map has `key`.
template <class U>
struct Case {
  std::string key;
  BoundKeys fields;  ///< of a U
};

/// Null where the key is not there; adds an issue where it is required.
const YamlEntry* find_field(const Cursor& map, const FieldWords& words, const FormSchema& schema);
/// One key, bound; `default_value` is shown in the reference.
BoundKeys bind_field(const FieldWords& words, const FormSchema& schema, const YamlNodePtr& default_value,
                     std::function<void(const Cursor&, void*)> read,
                     std::function<void(const void*, std::vector<YamlEntry>&)> write);
/// Exactly one of several cases; none or one where it is not `needed`.
BoundKeys bind_one_of(std::vector<std::string> names, std::vector<BoundKeys> cases, bool needed);
/// All fields of an object together, and then its checks, where each field is right.
BoundKeys bind_all(std::vector<BoundKeys> fields, std::vector<std::function<std::vector<Issue>(const void*)>> checks);

/// False where the node is no map or a field or check has added an issue.
bool read_map(const Cursor& cursor, const BoundKeys& fields, const FormSchema& schema, void* object);
YamlNodePtr write_map(const BoundKeys& fields, const void* object);
FormSchema map_schema(const BoundKeys& fields);

/// The table that binds the keys of a map to the members of a T, one line a member. From it a case file is read
/// strictly, the resolved case is echoed, and the reference and the JSON Schema are written.
template <class T>
class Fields {
public:
  /// A key that must be there.
  template <class M>
  Fields& required(const std::string& key, M T::*member, const Form<M>& form, const std::string& meaning) {
    return add_field({key, meaning, true}, member, form, nullptr);
  }

  /// A key that may be left out; then the member keeps the default of T{}.
  template <class M>
  Fields& optional(const std::string& key, M T::*member, const Form<M>& form, const std::string& meaning) {
    return add_field({key, meaning}, member, form, form.write(T{}.*member));
  }

  /// A key that may be left out; then the member stays empty.
  template <class M>
  Fields& optional(const std::string& key, std::optional<M> T::*member, const Form<M>& form,
                   const std::string& meaning) {
    return add_field({key, meaning}, member, form, nullptr);
  }

  /// Exactly one of the alternatives when() is there: its key says which type the variant holds. At most one for a
  /// std::optional<std::variant<...>>.
  template <class M, class... U>
  Fields& one_of(M T::*member, const Case<U>&... cases) {
    constexpr bool needed = !requires(M value) { value.reset(); };
    fields_.push_back(bind_one_of({cases.key...}, {bind_case(member, cases)...}, needed));
    return *this;
  }

  /// The fields of a member, in the same map.
  template <class M>
  Fields& inlined(M T::*member, const Fields<M>& fields) {
    const BoundKeys inner = fields.bound_keys();
    fields_.push_back({inner.keys,
                       [=](const Cursor& map, void* object) { inner.read(map, &(static_cast<T*>(object)->*member)); },
                       [=](const void* object, std::vector<YamlEntry>& entries) {
                         inner.write(&(static_cast<const T*>(object)->*member), entries);
                       },
                       inner.describe});
    return *this;
  }

  /// Requirements that several members meet together; called when each of them is right.
  Fields& check(std::function<std::vector<Issue>(const T&)> validate) {
    checks_.push_back([=](const void* object) { return validate(*static_cast<const T*>(object)); });
    return *this;
  }

  /// All fields as one; keys that are not known are left to the owner of the map.
  [[nodiscard]] BoundKeys bound_keys() const { return bind_all(fields_, checks_); }

private:
  template <class Member, class M>
  Fields& add_field(const FieldWords& words, Member T::*member, const Form<M>& form, const YamlNodePtr& default_value) {
    const auto read = [=](const Cursor& map, void* object) {
      const auto* entry = find_field(map, words, form.schema);
      if (!entry) return;
      if (auto value = form.read(map.at(*entry))) static_cast<T*>(object)->*member = std::move(*value);
    };
    const auto write = [=](const void* object, std::vector<YamlEntry>& entries) {
      const Member& value = static_cast<const T*>(object)->*member;
      if constexpr (std::is_same_v<Member, M>)
        entries.push_back({words.key, 0, form.write(value)});
      else if (value)
        entries.push_back({words.key, 0, form.write(*value)});
    };
    fields_.push_back(bind_field(words, form.schema, default_value, read, write));
    return *this;
  }

  /// The case's fields with the variant, or optional variant, in the place of the U that it holds.
  template <class M, class U>
  static BoundKeys bind_case(M T::*member, const Case<U>& alternative) {
    const BoundKeys fields = alternative.fields;
    return {fields.keys,
            [=](const Cursor& map, void* object) {
              U value{};
              fields.read(map, &value);
              static_cast<T*>(object)->*member = std::move(value);
            },
            [=](const void* object, std::vector<YamlEntry>& entries) {
              const M& value = static_cast<const T*>(object)->*member;
              if (const U* held = held_in<U>(value)) fields.write(held, entries);
            },
            fields.describe};
  }

  template <class U, class M>
  static const U* held_in(const M& value) {
    if constexpr (requires { value.has_value(); })
      return value ? std::get_if<U>(&*value) : nullptr;
    else
      return std::get_if<U>(&value);
  }

  std::vector<BoundKeys> fields_;
  std::vector<std::function<std::vector<Issue>(const void*)>> checks_;
};

/// The alternative `key: ...` whose value is written in the given form:  random: {rms: 3 mm, band: [0.5, 30]}.
template <class U>
Case<U> when(const std::string& key, const Form<U>& form, const std::string& meaning) {
  const FieldWords words{key, meaning, true};
  return {key, bind_field(
                   words, form.schema, nullptr,
                   [=](const Cursor& map, void* object) {
                     const auto* entry = find_field(map, words, form.schema);
                     if (!entry) return;
                     if (auto value = form.read(map.at(*entry))) *static_cast<U*>(object) = std::move(*value);
                   },
                   [=](const void* object, std::vector<YamlEntry>& entries) {
                     entries.push_back({key, 0, form.write(*static_cast<const U*>(object))});
                   })};
}

/// The alternative whose fields stand beside one another in the map; the first key selects it:  file: road.csv,
/// channel: r1.
template <class U>
Case<U> when(const Fields<U>& fields) {
  const BoundKeys bound = fields.bound_keys();
  return {bound.keys.front(), bound};
}

namespace form {

/// A map with the given fields and no other keys; nothing after the colon is an empty map.
template <class T>
Form<T> mapping(const Fields<T>& fields) {
  const BoundKeys bound = fields.bound_keys();
  const FormSchema schema = map_schema(bound);
  const auto read = [=](const Cursor& cursor) -> std::optional<T> {
    T object{};
    if (!read_map(cursor, bound, schema, &object)) return std::nullopt;
    return object;
  };
  return {read, [=](const T& object) { return write_map(bound, &object); }, schema};
}

}  // namespace form
}  // namespace kalfem
