// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/case_changes.hpp"
#include "kalfem/yaml/schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// Value of an environment variable, or nothing if it is not set.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;

/// The variables of this process.
Environment process_environment();

/// Replaces ${NAME} and ${NAME:-default} by the values of the variables. The default is used if NAME is unset or empty;
/// it may hold further ${...}. Values are not expanded again, and $${ stands for a literal ${. Throws InvalidInput for
/// an unset variable without a default, a bad name or a missing brace.
std::string expand_environment(const std::string& text, const Environment& environment);

/// Reads one YAML document into a tree. Resolves aliases and merge keys (<<) and expands environment variables in
/// values. Adds duplicate keys, keys that are not text and unset variables to `issues`. Throws InvalidInput if nothing
/// can be read: bad syntax, not UTF-8, an empty file, nesting or aliases without bounds. `name` names the file in
/// messages.
YamlNodePtr parse_yaml(const std::string& text, const std::string& name, const Environment& environment,
                       IssueList& issues);

/// The bytes of a file. Throws InvalidInput if it cannot be read or is too large for a case file (16 MB).
std::string read_text_file(const std::string& file);

/// Throws InvalidInput with the issues in the order of their lines; issues of other files come last. Does nothing if
/// there are none.
void raise_in_line_order(const IssueList& issues);

/// Reads the text of a case file in the given schema. `file` names it in messages, and paths are relative to its
/// folder. Problems go to `issues`; a value that has one keeps its default. `changes` are made before the text is read.
template <class T>
T read_case_text(const std::string& text, const std::string& file, const Schema<T>& schema, IssueList& issues,
                 const Environment& environment = process_environment(), const std::vector<CaseChange>& changes = {}) {
  ReadContext context{file, std::filesystem::path(file).parent_path(), {}, {}};
  T value{};
  try {
    const YamlNodePtr root = changed(parse_yaml(text, file, environment, context.issues), changes);
    schema.read(CaseNode(context, root, "", root->line), value);
  } catch (const InvalidInput& error) {
    context.issues.add(error, {file, 1});
  }
  for (const auto& [location, what, why, fix] : context.issues.issues()) issues.add(location, what, why, fix);
  return value;
}

/// As above, but throws InvalidInput with every problem that was found.
template <class T>
T read_case_text(const std::string& text, const std::string& file, const Schema<T>& schema,
                 const Environment& environment = process_environment()) {
  IssueList issues;
  T value = read_case_text(text, file, schema, issues, environment);
  raise_in_line_order(issues);
  return value;
}

/// Reads a case file; see read_case_text().
template <class T>
T read_case(const std::string& file, const Schema<T>& schema, const Environment& environment = process_environment()) {
  return read_case_text(read_text_file(file), file, schema, environment);
}

}  // namespace kalfem
