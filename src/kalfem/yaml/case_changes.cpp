// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/case_changes.hpp"

#include <algorithm>
#include <charconv>

#include "kalfem/yaml/case_reader.hpp"

namespace kalfem {
namespace {

using Keys = std::vector<std::string>;

Keys parts_of(const std::string& key) {
  Keys parts{""};
  for (const char c : key)
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// parts[0] ... parts[count - 1] with dots between them.
std::string joined(const Keys& parts, std::size_t count) {
  std::string key = parts[0];
  for (std::size_t i = 1; i < count; ++i) key += "." + parts[i];
  return key;
}

YamlNodePtr without_lines(const YamlNode& node) {
  YamlNode copy = node;
  copy.line = 0;
  for (auto& item : copy.items) item = without_lines(*item);
  for (auto& entry : copy.entries) entry = {entry.key, 0, without_lines(*entry.value)};
  return std::make_shared<const YamlNode>(std::move(copy));
}

YamlNodePtr parsed(const std::string& value, const std::string& name) {
  IssueList issues;
  YamlNodePtr node = parse_yaml(value, name, process_environment(), issues);
  issues.raise();
  return without_lines(*node);
}

/// Where in a list the item of that number or name stands.
std::size_t item_of(const YamlNode& list, const std::string& part) {
  std::size_t number = list.items.size();
  if (const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
      error == std::errc{} && end == part.data() + part.size() && number < list.items.size())
    return number;
  Keys names;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const auto* name = list.items[i]->find("name");
    if (name && name->value->text == part) return i;
    names.push_back(name ? name->value->text : std::to_string(i));
  }
  throw InvalidInput("the list has no item '" + part + "'" + did_you_mean(part, names), "",
                     "give its number from 0, or its name");
}

/// The node with the value at the place that the parts lead to; null removes what stands there.
YamlNodePtr with_value(const YamlNode& node, const Keys& parts, const YamlNodePtr& value) {
  const auto rest = [&](std::size_t count) {
    return Keys(parts.begin() + static_cast<std::ptrdiff_t>(count), parts.end());
  };
  YamlNode copy = node;
  if (node.kind == YamlNode::Kind::list) {
    const std::size_t at = item_of(node, parts[0]);
    if (parts.size() > 1)
      copy.items[at] = with_value(*node.items[at], rest(1), value);
    else if (value)
      copy.items[at] = value;
    else
      copy.items.erase(copy.items.begin() + static_cast<std::ptrdiff_t>(at));
    return std::make_shared<const YamlNode>(std::move(copy));
  }
  if (node.kind == YamlNode::Kind::scalar)
    throw InvalidInput("there is no key '" + parts[0] + "' in " + to_string(node), "it is one value",
                       "replace it as a whole");
  copy.kind = YamlNode::Kind::map;
  for (std::size_t count = parts.size(); count > 0; --count) {
    const auto found = std::ranges::find(copy.entries, joined(parts, count), &YamlEntry::key);
    if (found == copy.entries.end()) continue;
    if (count < parts.size())
      found->value = with_value(*found->value, rest(count), value);
    else if (value)
      *found = {found->key, 0, value};
    else
      copy.entries.erase(found);
    return std::make_shared<const YamlNode>(std::move(copy));
  }
  if (!value) throw InvalidInput("there is no such key", "it cannot be removed", "");
  const YamlNodePtr inner = parts.size() == 1 ? value : with_value(YamlNode{}, rest(1), value);
  copy.entries.push_back({parts[0], 0, inner});
  return std::make_shared<const YamlNode>(std::move(copy));
}

}  // namespace

YamlNodePtr changed(YamlNodePtr root, const std::vector<CaseChange>& changes) {
  IssueList issues;
  for (const auto& [key, value] : changes) {
    const std::string name = "set['" + key + "']";
    try {
      root = with_value(*root, parts_of(key), value ? parsed(*value, name) : nullptr);
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues()) issues.add({}, name + ": " + issue.what, issue.why, issue.fix);
    }
  }
  issues.raise();
  return root;
}

std::vector<Issue> with_changes_named(std::vector<Issue> issues, const std::vector<CaseChange>& changes) {
  const std::string ends = ": .[";
  for (auto& issue : issues) {
    const auto about = std::ranges::find_if(changes, [&](const auto& change) {
      return issue.what.starts_with(change.key) && issue.what.size() > change.key.size() &&
             ends.find(issue.what[change.key.size()]) != std::string::npos;
    });
    if (about != changes.end()) issue.what = "set['" + about->key + "']: " + issue.what;
    if (issue.what.starts_with("set['")) issue.location = {};
  }
  return issues;
}

}  // namespace kalfem
