// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/written_units.hpp"

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

/// What stands at the path; null where there is nothing.
const YamlNode* node_at(const YamlNodePtr& root, std::initializer_list<const char*> path) {
  const YamlNode* node = root.get();
  for (const char* key : path) {
    const auto* entry = node ? node->find(key) : nullptr;
    node = entry ? entry->value.get() : nullptr;
  }
  return node;
}

std::string unit_of_parameter(const YamlNode& parameter) {
  for (const char* key : {"initial", "truth", "std"})
    if (const auto* entry = parameter.find(key); entry && entry->value->kind == YamlNode::Kind::scalar)
      if (auto unit = unit_written_in(entry->value->text); !unit.empty()) return unit;
  return "";
}

}  // namespace

std::string unit_written_in(const std::string& text) {
  try {
    const auto quantity = parse_quantity(text);
    const auto end = text.find_last_not_of(' '), begin = text.find_first_not_of("+-.0123456789eE ");
    if (quantity.bare || quantity.value == 0.0 || begin == std::string::npos || text[begin] == '%') return "";
    return text.substr(begin, end - begin + 1);
  } catch (const InvalidInput&) {
    return "";
  }
}

std::map<std::string, std::string> written_units(const CaseSource& source) {
  std::map<std::string, std::string> units;
  for (const auto* section :
       {node_at(source.root(), {"estimate", "unknown"}), node_at(source.root(), {"update", "parameters"})}) {
    if (!section) continue;
    for (const auto& [key, line, value] : section->entries)
      if (auto unit = unit_of_parameter(*value); !unit.empty()) units[key] = std::move(unit);
  }
  return units;
}

}  // namespace kalfem
