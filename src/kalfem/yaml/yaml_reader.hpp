#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/yaml/environment.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem {

/// Reads one YAML document into a tree in which aliases and merge keys (<<) are resolved and environment variables in
/// values are expanded. Duplicate keys, keys that are not text and unset variables are added to `issues`; what leaves
/// nothing to read (syntax, not UTF-8, an empty file, nesting or aliases without bounds) throws InvalidInput. `name` is
/// used in messages.
YamlNodePtr parse_yaml(const std::string& text, const std::string& name, const Environment& environment,
                       IssueList& issues);

/// The bytes of a file. Throws InvalidInput when it cannot be read or is too large to be a case file (16 MB).
std::string read_text_file(const std::string& file);

}  // namespace kalfem
