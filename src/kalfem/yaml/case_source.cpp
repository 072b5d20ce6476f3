#include "kalfem/yaml/yaml_node.hpp"

#include <algorithm>

namespace kalfem {

SourceLocation CaseSource::at(const std::vector<std::string>& path) const {
  if (!root_) return {file_, 0};
  int line = root_->line;
  const YamlNode* node = root_.get();
  for (const auto& key : path) {
    const auto* entry = node->find(key);
    if (!entry) break;
    line = entry->line;
    node = entry->value.get();
  }
  return {file_, line};
}

bool CaseSource::gives(const std::vector<std::string>& path) const {
  const YamlNode* node = root_.get();
  for (const auto& key : path) {
    const auto* entry = node ? node->find(key) : nullptr;
    if (!entry) return false;
    node = entry->value.get();
  }
  return node != nullptr;
}

std::set<std::string> CaseSource::sections_of(const std::vector<Issue>& issues) const {
  std::set<std::string> sections;
  if (!root_) return sections;
  std::vector<int> starts, lines;
  for (const auto& entry : root_->entries) starts.push_back(entry.line);
  for (const auto& issue : issues)
    if (issue.location.file == file_) lines.push_back(issue.location.line);
  std::ranges::sort(starts);
  std::ranges::sort(lines);
  for (const auto& entry : root_->entries) {
    const auto next = std::ranges::upper_bound(starts, entry.line);
    const auto first = std::ranges::lower_bound(lines, entry.line);
    if (first != lines.end() && (*first == entry.line || next == starts.end() || *first < *next))
      sections.insert(entry.key);
  }
  return sections;
}

}  // namespace kalfem
