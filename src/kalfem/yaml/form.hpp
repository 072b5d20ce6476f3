#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// What one reading of a case file shares.
struct Reading {
  std::string file;
  std::filesystem::path folder;  ///< paths in the file are relative to it
  IssueList issues;
};

/// A value in the case file together with where it stands: its line and its path ("connectors.suspension.law").
class Cursor {
public:
  Cursor(Reading& reading, YamlNodePtr node, std::string path, int line)
      : reading_(&reading), node_(std::move(node)), path_(std::move(path)), line_(line) {}

  [[nodiscard]] const YamlNode& node() const { return *node_; }
  [[nodiscard]] const YamlNodePtr& shared_node() const { return node_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] SourceLocation location() const { return {reading_->file, line_}; }
  [[nodiscard]] const std::filesystem::path& folder() const { return reading_->folder; }
  [[nodiscard]] std::size_t issue_count() const { return reading_->issues.issues().size(); }

  [[nodiscard]] Cursor at(const YamlEntry& entry) const;
  [[nodiscard]] Cursor item(std::size_t index) const;  ///< path "bands[2]", counted from 0

  /// Adds "path: what: why; fix" to the issues of the reading.
  void issue(const std::string& what, const std::string& why = {}, const std::string& fix = {}) const;
  void issue(const InvalidInput& error) const;
  /// Whether the node is of that kind; otherwise adds an issue that shows how it is `written`.
  [[nodiscard]] bool require(YamlNode::Kind kind, const std::string& written) const;

private:
  Reading* reading_;
  YamlNodePtr node_;
  std::string path_;
  int line_;
};

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
