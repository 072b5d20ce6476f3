// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <set>
#include <string>
#include <vector>

#include "kalfem/yaml/json_schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

namespace kalfem::test {

/// Names that no case has, which mistakes put in the place of others.
constexpr std::array wrong_names{"a b!", "no-such", "no.such-word"};

/// A case with one mistake in it.
struct Mutation {
  std::string key;    ///< "connectors.suspension.law"
  std::string kind;   ///< "wrong type"
  std::string text;   ///< the whole case
  bool wrong = true;  ///< false: a word was changed that may be free text
};

/// Every mistake of every key: what the schema says of a key decides which there are. `reached` collects the keys as
/// the schema has them, without the user's names.
std::vector<Mutation> mutations_of(const YamlNodePtr& root, const JsonSchema& schema, std::set<std::string>& reached);

/// All keys of the schema, as mutations_of() collects them.
std::set<std::string> keys_of(const JsonSchema& schema);

}  // namespace kalfem::test
