// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

struct YamlNode;
using YamlNodePtr = std::shared_ptr<const YamlNode>;

/// "key: value" in a map.
struct YamlEntry {
  std::string key;
  int line = 0;
  YamlNodePtr value;
};

/// A YAML value, immutable once it is built. Reading and writing use the same type.
struct YamlNode {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  std::string text{};                ///< of a scalar
  bool literal = true;               ///< scalar written without quotes: a number, a choice, true or false
  std::vector<YamlNodePtr> items{};  ///< of a list
  std::vector<YamlEntry> entries{};  ///< of a map, in file order
  int line = 0;                      ///< 1-based; 0 if it was not read from a file
  std::string comment{};             ///< written after the value, usually the unit
  std::size_t weight = 1;            ///< nodes below and including this one, aliases counted each time

  /// The entry, or null if the map has no such key.
  [[nodiscard]] const YamlEntry* find(const std::string& key) const;
};

YamlNodePtr yaml_literal(std::string text, std::string comment = {});
YamlNodePtr yaml_text(std::string text);
YamlNodePtr yaml_list(std::vector<YamlNodePtr> items, std::string comment = {});
YamlNodePtr yaml_map(std::vector<YamlEntry> entries);

/// "a map", "a list", "nothing" or the scalar in quotes, for messages.
std::string to_string(const YamlNode& node);

/// A document that was written with all its defaults, without the keys that neither the user's `source` gives nor
/// changed since `before`, the same document as it was read. Whole if there is no source.
YamlNodePtr as_given(const YamlNodePtr& written, const YamlNodePtr& before, const YamlNodePtr& source);

/// The document as YAML text: maps as blocks, lists of scalars on one line, comments after the values.
std::string to_yaml(const YamlNode& root);

/// The file from which a case was read: the keys that it gives, and their lines. Immutable.
class CaseSource {
public:
  CaseSource() = default;
  CaseSource(std::string file, YamlNodePtr root, std::vector<std::filesystem::path> files = {})
      : file_(std::move(file)), root_(std::move(root)), files_(std::move(files)) {}

  /// Place of the key at that path ({"estimate", "unknown"}), or of the innermost key above it that the file gives.
  /// Without a line if the case was not read from a file.
  [[nodiscard]] SourceLocation at(const std::vector<std::string>& path) const;
  /// Whether the file gives the key at that path.
  [[nodiscard]] bool gives(const std::vector<std::string>& path) const;
  /// Whether the case was not read from a file.
  [[nodiscard]] bool empty() const { return !root_; }
  /// The document that the file holds; null if there is none.
  [[nodiscard]] const YamlNodePtr& root() const { return root_; }
  /// The files that the case names: records, decks, tables.
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return files_; }
  /// The top-level keys with an issue at one of their lines.
  [[nodiscard]] std::set<std::string> sections_of(const std::vector<Issue>& issues) const;

private:
  std::string file_;
  YamlNodePtr root_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace kalfem
