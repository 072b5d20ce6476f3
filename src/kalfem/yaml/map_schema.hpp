// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <variant>

#include "kalfem/yaml/schemas.hpp"

namespace kalfem {

/// Position of a member in its object: bytes from the start.
using MemberOffset = std::ptrdiff_t;

/// Some keys of a map, bound to members of an object. Only the Fields<T> that made it knows the type of the object, so
/// code that all maps share is compiled once (map_schema.cpp). Immutable.
class Field {
public:
  explicit Field(std::vector<std::string> names) : keys(std::move(names)) {}
  Field(const Field&) = delete;
  Field& operator=(const Field&) = delete;
  virtual ~Field() = default;

  virtual void read(const CaseNode& map, void* object) const = 0;
  virtual void write(const void* object, std::vector<YamlEntry>& entries) const = 0;
  /// Adds to properties, required and allOf of the map's json_schema.
  virtual void document(nlohmann::ordered_json& json_schema) const = 0;

  const std::vector<std::string> keys;
};

using FieldPtr = std::shared_ptr<const Field>;

/// Name and meaning of a key.
struct FieldInfo {
  std::string_view key, meaning;
  bool required = false;
};

/// Access to a member that holds one of several types, for one of these types, U.
struct VariantAccess {
  void (*read)(const Field& fields, const CaseNode& map, void* member);  ///< stores the U that was read
  const void* (*held)(const void* member);                               ///< its U; null if it holds another type
};

/// One key, whose value is the member at `offset`; `default_value` is shown in the reference.
FieldPtr bind_field(const FieldInfo& words, const AnySchemaPtr& schema, MemberOffset offset,
                    const YamlNodePtr& default_value);
/// Keys of the object at `offset` in another.
FieldPtr bind_inlined(const FieldPtr& inner, MemberOffset offset);
/// Keys of an object that the member at `offset` may hold.
FieldPtr bind_held(const FieldPtr& fields, const VariantAccess& type, MemberOffset offset);
/// Exactly one of several cases, each selected by its name; at most one if it is not `needed`.
FieldPtr bind_one_of(std::vector<std::string> names, std::vector<FieldPtr> cases, bool needed);

/// The part of Fields<T> that does not depend on T.
class FieldTable {
public:
  /// Requirements on several members together.
  using Check = std::function<std::vector<Issue>(const void* object)>;

  FieldTable();
  FieldTable(const FieldTable&);
  FieldTable& operator=(const FieldTable&) = delete;
  ~FieldTable();

  /// All fields as one. The checks run if every field is right. Unknown keys are left to the owner of the map.
  [[nodiscard]] FieldPtr as_one_field() const;

protected:
  void add(FieldPtr keys);
  void add(Check check);

private:
  std::vector<FieldPtr> fields_;
  std::vector<Check> checks_;
};

/// The schema of an object with these keys and no other ones; nothing after the colon is an empty map.
AnySchemaPtr map_schema(const FieldPtr& keys);

/// A schema of a value that may be empty.
template <class M>
class OptionalSchema final : public AnySchema {
public:
  explicit OptionalSchema(Schema<M> schema) : AnySchema(schema.json_schema()), schema_(std::move(schema)) {}
  bool read(const CaseNode& node, void* value) const override {
    return schema_.read(node, static_cast<std::optional<M>*>(value)->emplace());
  }
  YamlNodePtr write(const void* value) const override {
    const auto& held = *static_cast<const std::optional<M>*>(value);
    return held ? schema_.write(*held) : nullptr;
  }

private:
  Schema<M> schema_;
};

/// One alternative of Fields::one_of: `key` in the map selects the type U.
template <class U>
struct Case {
  std::string key;
  FieldPtr fields;  ///< of a U
};

/// Access to a member M that is a std::variant, or an optional one, with U among its types.
template <class M, class U>
constexpr VariantAccess variant_access() {
  return {[](const Field& fields, const CaseNode& map, void* member) {
            U value{};
            fields.read(map, &value);
            *static_cast<M*>(member) = std::move(value);
          },
          [](const void* member) -> const void* {
            const M& value = *static_cast<const M*>(member);
            if constexpr (requires { value.has_value(); })
              return value ? std::get_if<U>(&*value) : nullptr;
            else
              return std::get_if<U>(&value);
          }};
}

/// The table that binds the keys of a map to the members of a T, one line per member. One table serves three ends: it
/// reads a case file strictly, writes the resolved case, and documents the keys (reference and JSON Schema).
template <class T>
class Fields : public FieldTable {
public:
  /// A key that must be there.
  template <class M>
  Fields& required(std::string_view key, M T::*member, const Schema<M>& schema, std::string_view meaning) {
    add(bind_field({key, meaning, true}, schema.any(), offset_of(member), nullptr));
    return *this;
  }

  /// A key that may be left out; then the member keeps the default of T{}.
  template <class M>
  Fields& optional(std::string_view key, M T::*member, const Schema<M>& schema, std::string_view meaning) {
    add(bind_field({key, meaning}, schema.any(), offset_of(member), schema.write(defaults_.*member)));
    return *this;
  }

  /// A key that may be left out; then the member stays empty.
  template <class M>
  Fields& optional(std::string_view key, std::optional<M> T::*member, const Schema<M>& schema,
                   std::string_view meaning) {
    add(bind_field({key, meaning}, std::make_shared<const OptionalSchema<M>>(schema), offset_of(member), nullptr));
    return *this;
  }

  /// Exactly one of the alternatives when() is there: its key says which type the variant holds. At most one for a
  /// std::optional<std::variant<...>>.
  template <class M, class... U>
  Fields& one_of(M T::*member, const Case<U>&... cases) {
    constexpr bool needed = !requires(M value) { value.reset(); };
    const MemberOffset offset = offset_of(member);
    add(bind_one_of({cases.key...}, {bind_held(cases.fields, variant_access<M, U>(), offset)...}, needed));
    return *this;
  }

  /// The fields of a member, in the same map.
  template <class M>
  Fields& inlined(M T::*member, const Fields<M>& fields) {
    add(bind_inlined(fields.as_one_field(), offset_of(member)));
    return *this;
  }

  /// Requirements on several members together; called if each member is right.
  Fields& check(std::function<std::vector<Issue>(const T&)> validate) {
    add([=](const void* object) { return validate(*static_cast<const T*>(object)); });
    return *this;
  }

private:
  template <class M>
  MemberOffset offset_of(M T::*member) const {
    return reinterpret_cast<const std::byte*>(&(defaults_.*member)) - reinterpret_cast<const std::byte*>(&defaults_);
  }

  T defaults_{};
};

/// The alternative `key: ...` whose value is written in the given schema:  random: {rms: 3 mm, band: [0.5, 30]}.
template <class U>
Case<U> when(std::string_view key, const Schema<U>& schema, std::string_view meaning) {
  return {std::string(key), bind_field({key, meaning, true}, schema.any(), MemberOffset{0}, nullptr)};
}

/// The alternative whose fields stand beside one another in the map; the first key selects it:  file: road.csv,
/// channel: r1.
template <class U>
Case<U> when(const Fields<U>& fields) {
  const FieldPtr bound = fields.as_one_field();
  return {bound->keys.front(), bound};
}

namespace schema {

/// A map with the given fields and no other keys; nothing after the colon is an empty map.
template <class T>
Schema<T> mapping(const Fields<T>& fields) {
  return Schema<T>(map_schema(fields.as_one_field()));
}

}  // namespace schema
}  // namespace kalfem
