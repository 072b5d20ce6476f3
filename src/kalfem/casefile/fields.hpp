#pragma once

#include <memory>
#include <string_view>
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

/// A form for a value whose type only its maker knows.
struct BoundForm {
  std::function<void(const Cursor&, void* value)> read;  ///< leaves the value as it is where the text is not usable
  std::function<YamlNodePtr(const void* value)> write;   ///< null for an empty value
  FormSchema schema;
};

/// The form of an M for a `Value` that is an M or may hold one.
template <class Value, class M>
BoundForm bind_form(const Form<M>& form) {
  return {[read = form.read](const Cursor& cursor, void* value) {
            if (auto given = read(cursor)) *static_cast<Value*>(value) = std::move(*given);
          },
          [write = form.write](const void* value) -> YamlNodePtr {
            const auto& held = *static_cast<const Value*>(value);
            if constexpr (std::is_same_v<Value, M>)
              return write(held);
            else
              return held ? write(*held) : nullptr;
          },
          form.schema};
}

/// A key in words.
struct FieldWords {
  std::string_view key, meaning;
  bool required = false;
};

/// One alternative of Fields::one_of: the kind U that is meant when the map has `key`.
template <class U>
struct Case {
  std::string key;
  BoundKeys fields;  ///< of a U
};

/// Where a value stands in an object.
using Place = std::function<const void*(const void* object)>;

/// One key, bound; `default_value` is shown in the reference.
BoundKeys bind_field(const FieldWords& words, const BoundForm& form, const Place& place,
                     const YamlNodePtr& default_value);
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
  Fields& required(std::string_view key, M T::*member, const Form<M>& form, std::string_view meaning) {
    return add_field({key, meaning, true}, member, bind_form<M>(form), nullptr);
  }

  /// A key that may be left out; then the member keeps the default of T{}.
  template <class M>
  Fields& optional(std::string_view key, M T::*member, const Form<M>& form, std::string_view meaning) {
    return add_field({key, meaning}, member, bind_form<M>(form), form.write(defaults_.*member));
  }

  /// A key that may be left out; then the member stays empty.
  template <class M>
  Fields& optional(std::string_view key, std::optional<M> T::*member, const Form<M>& form, std::string_view meaning) {
    return add_field({key, meaning}, member, bind_form<std::optional<M>>(form), nullptr);
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
  template <class M>
  Fields& add_field(const FieldWords& words, M T::*member, const BoundForm& form, const YamlNodePtr& default_value) {
    const auto place = [member](const void* object) -> const void* {
      return &(static_cast<const T*>(object)->*member);
    };
    fields_.push_back(bind_field(words, form, place, default_value));
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

  T defaults_{};
  std::vector<BoundKeys> fields_;
  std::vector<std::function<std::vector<Issue>(const void*)>> checks_;
};

/// The alternative `key: ...` whose value is written in the given form:  random: {rms: 3 mm, band: [0.5, 30]}.
template <class U>
Case<U> when(std::string_view key, const Form<U>& form, std::string_view meaning) {
  const auto itself = [](const void* object) { return object; };
  return {std::string(key), bind_field({key, meaning, true}, bind_form<U>(form), itself, nullptr)};
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
