#pragma once

#include <functional>
#include <optional>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// Value of an environment variable, or nothing when it is not set.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;

/// The variables of this process.
Environment process_environment();

/// Replaces ${NAME} and ${NAME:-default} (used when NAME is unset or empty; may hold further ${...}) by the variables'
/// values, which are not expanded again; $${ stands for a literal ${. Throws InvalidInput for a variable that is not
/// set and has no default, a bad name or a missing brace.
std::string expand_environment(const std::string& text, const Environment& environment);

/// Reads one YAML document into a tree in which aliases and merge keys (<<) are resolved and environment variables in
/// values are expanded. Duplicate keys, keys that are not text and unset variables are added to `issues`; what leaves
/// nothing to read (syntax, not UTF-8, an empty file, nesting or aliases without bounds) throws InvalidInput. `name` is
/// used in messages.
YamlNodePtr parse_yaml(const std::string& text, const std::string& name, const Environment& environment,
                       IssueList& issues);

/// The bytes of a file. Throws InvalidInput when it cannot be read or is too large to be a case file (16 MB).
std::string read_text_file(const std::string& file);

}  // namespace kalfem
