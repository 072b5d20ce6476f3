#pragma once

#include <set>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// The file from which a case was read: where its keys stand, and which of them it gives. Immutable.
class CaseSource {
public:
  CaseSource() = default;
  CaseSource(std::string file, YamlNodePtr root) : file_(std::move(file)), root_(std::move(root)) {}

  /// Place of the key at that path ({"estimate", "unknown"}), or of the innermost key above it that the file gives.
  /// Without a line where the case was not read from a file.
  [[nodiscard]] SourceLocation at(const std::vector<std::string>& path) const;
  /// Whether the file gives the key at that path.
  [[nodiscard]] bool gives(const std::vector<std::string>& path) const;
  /// Whether there is a file to speak of.
  [[nodiscard]] bool empty() const { return !root_; }
  /// The top-level keys whose lines hold one of the issues.
  [[nodiscard]] std::set<std::string> sections_of(const std::vector<Issue>& issues) const;

private:
  std::string file_;
  YamlNodePtr root_;
};

}  // namespace kalfem
