// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// A key of a case with the value that it gets instead of its own: {"simulate.duration", "4 s"}.
struct CaseChange {
  /// Keys joined by dots, from the top level on. Keys may hold dots themselves: the longest one that the case has
  /// counts. An item of a list is its number from 0, or its `name`.
  std::string key;
  std::optional<std::string> value = {};  ///< in YAML; nothing: the key is removed
};

/// The document with these changes, one after the other. Keys that are missing are added; they and new values have no
/// line. Throws InvalidInput with every change whose key leads nowhere or whose value is not YAML, as "set['key']".
YamlNodePtr changed(YamlNodePtr root, const std::vector<CaseChange>& changes);

/// Names the change behind each issue about a changed key, in place of a line: "set['simulate.duration']: ...".
std::vector<Issue> with_changes_named(std::vector<Issue> issues, const std::vector<CaseChange>& changes);

}  // namespace kalfem
