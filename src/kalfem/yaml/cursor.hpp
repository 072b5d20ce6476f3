#pragma once

#include <filesystem>
#include <string>

#include "kalfem/base/invalid_input.hpp"
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

}  // namespace kalfem
