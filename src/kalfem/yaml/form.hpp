#pragma once

#include <memory>
#include <string>
#include <utility>

#include "kalfem/yaml/cursor.hpp"
#include "kalfem/yaml/form_schema.hpp"

namespace kalfem {

/// How a value is written in a case file: the one description from which it is read, echoed and documented. The type of
/// the value is known only to those who made the form: what does not depend on it is so compiled once. Immutable.
class AnyForm {
public:
  explicit AnyForm(FormSchema given) : schema(std::move(given)) {}
  AnyForm(const AnyForm&) = delete;
  AnyForm& operator=(const AnyForm&) = delete;
  virtual ~AnyForm() = default;

  /// False where the text is not usable: then an issue was added, and the value is of no use.
  virtual bool read(const Cursor& cursor, void* value) const = 0;
  /// Null for an empty value.
  virtual YamlNodePtr write(const void* value) const = 0;

  const FormSchema schema;
};

using AnyFormPtr = std::shared_ptr<const AnyForm>;

/// The form of a T, shared by all copies.
template <class T>
class Form {
public:
  using Value = T;

  explicit Form(AnyFormPtr form) : form_(std::move(form)) {}

  /// False where the text is not usable: then an issue was added, and the value is of no use.
  bool read(const Cursor& cursor, T& value) const { return form_->read(cursor, &value); }
  [[nodiscard]] YamlNodePtr write(const T& value) const { return form_->write(&value); }
  [[nodiscard]] const FormSchema& schema() const { return form_->schema; }
  [[nodiscard]] std::string written() const { return schema().written(); }
  [[nodiscard]] const AnyFormPtr& any() const { return form_; }

private:
  AnyFormPtr form_;
};

/// The form that reads with bool read(const Cursor&, T&) and writes with YamlNodePtr write(const T&).
template <class T, class Read, class Write>
Form<T> make_form(Read read, Write write, FormSchema schema) {
  class Made final : public AnyForm {
  public:
    Made(Read read, Write write, FormSchema given)
        : AnyForm(std::move(given)), read_(std::move(read)), write_(std::move(write)) {}
    bool read(const Cursor& cursor, void* value) const override { return read_(cursor, *static_cast<T*>(value)); }
    YamlNodePtr write(const void* value) const override { return write_(*static_cast<const T*>(value)); }

  private:
    Read read_;
    Write write_;
  };
  std::unique_ptr<const AnyForm> made(new Made(std::move(read), std::move(write), std::move(schema)));
  return Form<T>(std::move(made));
}

}  // namespace kalfem
