// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/json_schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// Shared by all nodes while one case file is read.
struct ReadContext {
  std::string file;
  std::filesystem::path folder;  ///< paths in the file are relative to it
  IssueList issues;
  std::vector<std::filesystem::path> files = {};  ///< that the case names and that are there, in its order
};

/// A value in the case file with its line and its path ("connectors.suspension.law").
class CaseNode {
public:
  CaseNode(ReadContext& context, YamlNodePtr node, std::string path, int line)
      : context_(&context), node_(std::move(node)), path_(std::move(path)), line_(line) {}

  [[nodiscard]] const YamlNode& yaml() const { return *node_; }
  [[nodiscard]] const YamlNodePtr& shared_yaml() const { return node_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] SourceLocation location() const { return {context_->file, line_}; }
  [[nodiscard]] const std::filesystem::path& folder() const { return context_->folder; }
  [[nodiscard]] std::size_t issue_count() const { return context_->issues.issues().size(); }
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return context_->files; }
  void add_file(const std::filesystem::path& file) const { context_->files.push_back(file); }

  [[nodiscard]] CaseNode at(const YamlEntry& entry) const;
  [[nodiscard]] CaseNode item(std::size_t index) const;  ///< path "bands[2]", counted from 0

  /// Adds "path: what: why; fix" to the issues of the file.
  void issue(const std::string& what, const std::string& why = {}, const std::string& fix = {}) const;
  void issue(const InvalidInput& error) const;
  /// Whether the node is of that kind; otherwise adds an issue that shows how it is `written`.
  [[nodiscard]] bool require(YamlNode::Kind kind, const std::string& written) const;

private:
  ReadContext* context_;
  YamlNodePtr node_;
  std::string path_;
  int line_;
};

/// Describes how a value is written in a case file. The same description reads the value, writes it and documents it.
/// Only the maker of the schema knows the type of the value, so code that does not depend on it is compiled once.
/// Immutable.
class AnySchema {
public:
  explicit AnySchema(JsonSchema given) : json_schema(std::move(given)) {}
  AnySchema(const AnySchema&) = delete;
  AnySchema& operator=(const AnySchema&) = delete;
  virtual ~AnySchema() = default;

  /// False where the text is not usable: then an issue was added, and the value is of no use.
  virtual bool read(const CaseNode& node, void* value) const = 0;
  /// Null for an empty value.
  virtual YamlNodePtr write(const void* value) const = 0;

  const JsonSchema json_schema;
};

using AnySchemaPtr = std::shared_ptr<const AnySchema>;

/// The schema of a T, shared by all copies.
template <class T>
class Schema {
public:
  using Value = T;

  explicit Schema(AnySchemaPtr schema) : schema_(std::move(schema)) {}

  /// False where the text is not usable: then an issue was added, and the value is of no use.
  bool read(const CaseNode& node, T& value) const { return schema_->read(node, &value); }
  [[nodiscard]] YamlNodePtr write(const T& value) const { return schema_->write(&value); }
  [[nodiscard]] const JsonSchema& json_schema() const { return schema_->json_schema; }
  [[nodiscard]] std::string written() const { return json_schema().written(); }
  [[nodiscard]] const AnySchemaPtr& any() const { return schema_; }

private:
  AnySchemaPtr schema_;
};

/// Makes a schema of bool read(const CaseNode&, T&) and YamlNodePtr write(const T&).
template <class T, class Read, class Write>
Schema<T> make_schema(Read read, Write write, JsonSchema json_schema) {
  class Made final : public AnySchema {
  public:
    Made(Read read, Write write, JsonSchema given)
        : AnySchema(std::move(given)), read_(std::move(read)), write_(std::move(write)) {}
    bool read(const CaseNode& node, void* value) const override { return read_(node, *static_cast<T*>(value)); }
    YamlNodePtr write(const void* value) const override { return write_(*static_cast<const T*>(value)); }

  private:
    Read read_;
    Write write_;
  };
  std::unique_ptr<const AnySchema> made(new Made(std::move(read), std::move(write), std::move(json_schema)));
  return Schema<T>(std::move(made));
}

}  // namespace kalfem
