// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/yaml_node.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

bool is_plain_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.' || c == '/';
}

/// Words that YAML readers do not take as text.
bool is_reserved(const std::string& text) {
  const std::string word = lower_case(text);
  constexpr std::array words{"null", "true", "false", "yes", "no", "on", "off", "y", "n", "nan", "inf"};
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (text.compare(i, 2, "${") == 0) out += '$';  // a literal ${, not an environment variable
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return with_unicode_escapes(out) + '"';
}

std::string key_text(const std::string& key) {
  const bool plain = !key.empty() && key.front() != '-' && key.front() != '.' &&
                     std::all_of(key.begin(), key.end(), is_plain_character) && !is_reserved(key);
  return plain ? key : in_quotes(key);
}

std::string scalar_text(const YamlNode& node) {
  if (node.literal) return node.text;
  const bool plain =
      !node.text.empty() && (std::isalpha(static_cast<unsigned char>(node.text.front())) || node.text.front() == '/') &&
      std::all_of(node.text.begin(), node.text.end(), [](char c) { return is_plain_character(c) || c == ' '; }) &&
      node.text.back() != ' ' && !is_reserved(node.text);
  return plain ? node.text : in_quotes(node.text);
}

bool is_scalar(const YamlNodePtr& node) {
  return node->kind == YamlNode::Kind::scalar || node->kind == YamlNode::Kind::null;
}

bool fits_one_line(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::map:
      return node.entries.empty();
    case YamlNode::Kind::list:
      return std::all_of(node.items.begin(), node.items.end(), is_scalar);
    default:
      return true;
  }
}

std::string one_line(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null:
      return "null";
    case YamlNode::Kind::scalar:
      return scalar_text(node);
    case YamlNode::Kind::map:
      return "{}";
    case YamlNode::Kind::list:
      break;
  }
  std::string text;
  for (const auto& item : node.items) text += (text.empty() ? "" : ", ") + one_line(*item);
  return "[" + text + "]";
}

std::string with_comment(const YamlNode& node) {
  return one_line(node) + (node.comment.empty() ? "" : "  # " + node.comment) + "\n";
}

/// Writes a map or list as a block: one line per key or item, deeper ones indented by two blanks. Values that fit stay
/// on the line of their key; the first line of an item stands behind its dash.
std::string block(const YamlNode& node, const std::string& indent) {
  if (fits_one_line(node)) return indent + with_comment(node);
  std::string text;
  for (const auto& entry : node.entries) {
    text += indent + key_text(entry.key) + ":";
    text += fits_one_line(*entry.value) ? " " + with_comment(*entry.value) : "\n" + block(*entry.value, indent + "  ");
  }
  for (const auto& item : node.items) {
    const std::string inner = block(*item, indent + "  ");
    text += indent + "- " + inner.substr(indent.size() + 2);
  }
  return text;
}

}  // namespace

const YamlEntry* YamlNode::find(const std::string& key) const {
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const YamlEntry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &*found;
}

YamlNodePtr yaml_literal(std::string text, std::string comment) {
  YamlNode node{.kind = YamlNode::Kind::scalar, .text = std::move(text)};
  node.comment = std::move(comment);
  return std::make_shared<YamlNode>(std::move(node));
}

YamlNodePtr yaml_text(std::string text) {
  return std::make_shared<YamlNode>(
      YamlNode{.kind = YamlNode::Kind::scalar, .text = std::move(text), .literal = false});
}

YamlNodePtr yaml_list(std::vector<YamlNodePtr> items, std::string comment) {
  YamlNode node{.kind = YamlNode::Kind::list, .items = std::move(items)};
  node.comment = std::move(comment);
  return std::make_shared<YamlNode>(std::move(node));
}

YamlNodePtr yaml_map(std::vector<YamlEntry> entries) {
  return std::make_shared<YamlNode>(YamlNode{.kind = YamlNode::Kind::map, .entries = std::move(entries)});
}

std::string to_string(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null:
      return "nothing";
    case YamlNode::Kind::list:
      return "a list";
    case YamlNode::Kind::map:
      return "a map";
    case YamlNode::Kind::scalar:
      break;
  }
  return "'" + node.text.substr(0, 80) + (node.text.size() > 80 ? "..." : "") + "'";
}

// Goes down the three trees together. Lists of the same length correspond item by item.
YamlNodePtr as_given(const YamlNodePtr& written, const YamlNodePtr& before, const YamlNodePtr& source) {
  if (!source || !before || source->kind != written->kind || before->kind != written->kind) return written;
  YamlNode kept = *written;
  if (written->kind == YamlNode::Kind::map) {
    kept.entries.clear();
    for (const auto& entry : written->entries) {
      const auto *own = source->find(entry.key), *former = before->find(entry.key);
      const bool changed = !former || to_yaml(*former->value) != to_yaml(*entry.value);
      const YamlNodePtr part = own && former ? as_given(entry.value, former->value, own->value) : entry.value;
      if (own || changed) kept.entries.push_back({entry.key, 0, part});
    }
  }
  const auto items = written->items.size();
  if (items == source->items.size() && items == before->items.size())
    for (std::size_t i = 0; i < items; ++i)
      kept.items[i] = as_given(written->items[i], before->items[i], source->items[i]);
  return std::make_shared<YamlNode>(std::move(kept));
}

std::string to_yaml(const YamlNode& root) { return block(root, ""); }

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
