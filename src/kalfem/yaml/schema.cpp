// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/schema.hpp"

namespace kalfem {

CaseNode CaseNode::at(const YamlEntry& entry) const {
  return {*context_, entry.value, path_.empty() ? entry.key : path_ + "." + entry.key, entry.line};
}

CaseNode CaseNode::item(std::size_t index) const {
  const auto& node = node_->items[index];
  return {*context_, node, path_ + "[" + std::to_string(index) + "]", node->line};
}

void CaseNode::issue(const std::string& what, const std::string& why, const std::string& fix) const {
  context_->issues.add(location(), path_.empty() ? what : path_ + ": " + what, why, fix);
}

void CaseNode::issue(const InvalidInput& error) const {
  for (const auto& each : error.issues()) issue(each.what, each.why, each.fix);
}

bool CaseNode::require(YamlNode::Kind kind, const std::string& written) const {
  if (node_->kind == kind) return true;
  issue(to_string(*node_) + " given", "", "write " + written);
  return false;
}

}  // namespace kalfem
