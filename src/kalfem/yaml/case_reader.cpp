// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/case_reader.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <unordered_map>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/yaml/yaml_mistakes.hpp"

namespace kalfem {
namespace {

constexpr int deepest_default = 20;

/// Expands ${...} by recursive descent: each ${ opens a level, whose default is read up to its own closing brace.
/// Values of variables are copied and not read again. An unused default is read too, so that its braces are checked.
class Expander {
public:
  Expander(std::string_view text, const Environment& environment) : text_(text), environment_(environment) {}

  std::string expand() { return until_brace(0); }

private:
  /// Copies up to the closing brace of the enclosing ${ (depth > 0) or the end of the text.
  std::string until_brace(int depth) {
    if (depth > deepest_default) fail("the defaults are nested too deeply", "use fewer nested ${...}");
    std::string out;
    while (position_ < text_.size() && !(depth > 0 && text_[position_] == '}')) {
      if (take("$${")) {
        out += "${";
      } else if (take("${")) {
        out += variable(depth);
      } else {
        out += text_[position_++];
      }
    }
    return out;
  }

  /// The value of ${...}. An unused default is still read to its brace, but may name unset variables.
  std::string variable(int depth) {
    const std::string name = variable_name();
    const std::optional<std::string> value = environment_(name);
    std::optional<std::string> fallback;
    if (take(":-")) {
      const bool is_used = !value || value->empty();
      unused_ += is_used ? 0 : 1;
      fallback = until_brace(depth + 1);
      unused_ -= is_used ? 0 : 1;
    }
    if (!take("}")) {
      fail("a '}' is missing, or the name has characters other than letters, digits and _",
           "write ${NAME} or ${NAME:-default}");
    }
    if (value && !(value->empty() && fallback)) return *value;
    if (!fallback && unused_ == 0) {
      fail("the environment variable " + name + " is not set", "set it or write ${" + name + ":-default}");
    }
    return fallback.value_or("");
  }

  std::string variable_name() {
    const std::size_t begin = position_;
    while (position_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[position_])) || text_[position_] == '_'))
      ++position_;
    if (position_ == begin)
      fail("${ is not followed by a name", "write ${NAME} or ${NAME:-default}; $${ for a literal ${");
    return std::string(text_.substr(begin, position_ - begin));
  }

  bool take(std::string_view token) {
    if (text_.substr(position_, token.size()) != token) return false;
    position_ += token.size();
    return true;
  }

  [[noreturn]] void fail(const std::string& why, const std::string& fix) const {
    throw InvalidInput("'" + std::string(text_.substr(0, 200)) + "'", why, fix);
  }

  std::string_view text_;
  const Environment& environment_;
  std::size_t position_ = 0;
  int unused_ = 0;  ///< defaults around this place that are not used
};

}  // namespace

Environment process_environment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    if (!value) return std::nullopt;
    return value;
  };
}

std::string expand_environment(const std::string& text, const Environment& environment) {
  return text.find("${") == std::string::npos ? text : Expander(text, environment).expand();
}

namespace {

constexpr std::uintmax_t largest_file = 16 << 20;
constexpr std::size_t largest_tree = 200'000;
constexpr std::size_t deepest_tree = 100;

/// Builds the tree bottom-up from the parser's events. `open_` is the stack of unfinished maps and lists; its last one
/// receives the next value. A map waits with a key for its value. At the end of a map its merge sources (<<) add the
/// keys that it lacks. Each node counts the nodes below it, aliases every time, so a file that multiplies values by
/// aliases is refused early.
class TreeBuilder : public YAML::EventHandler {
public:
  TreeBuilder(std::string name, const Environment& environment, IssueList& issues)
      : name_(std::move(name)), environment_(environment), issues_(issues) {}

  YamlNodePtr root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(std::make_shared<YamlNode>(YamlNode{.line = mark.line + 1}), anchor, mark.line + 1);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode node{.kind = YamlNode::Kind::scalar, .text = value, .literal = tag != "!", .line = mark.line + 1};
    if (!expects_key()) node.text = expand(value, node.line);
    add(std::make_shared<YamlNode>(std::move(node)), anchor, mark.line + 1);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) fail(mark.line + 1, "the alias is inside the value that it refers to", "");
    add(found->second, 0, mark.line + 1);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::list, mark, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::map, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

private:
  struct Unfinished {
    YamlNode node;
    YAML::anchor_t anchor = 0;
    std::optional<YamlEntry> key;                 ///< read; its value follows
    std::vector<YamlNodePtr> merged{};            ///< values of <<
    std::unordered_map<std::string, int> keys{};  ///< with their lines
  };

  [[nodiscard]] bool expects_key() const {
    return !open_.empty() && open_.back().node.kind == YamlNode::Kind::map && !open_.back().key;
  }

  void open(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (open_.size() == deepest_tree)
      fail(mark.line + 1, "the file is nested too deeply", "at most 100 levels are read");
    if (expects_key())
      fail(mark.line + 1, "this is not YAML: a list or a map stands where a key should",
           "close every bracket and brace; a key must be a word or a number");
    open_.push_back({YamlNode{.kind = kind, .line = mark.line + 1}, anchor, std::nullopt});
  }

  void close() {
    Unfinished done = std::move(open_.back());
    open_.pop_back();
    for (const auto& source : done.merged) merge(*source, done);
    const int line = done.node.line;
    add(std::make_shared<YamlNode>(std::move(done.node)), done.anchor, line);
  }

  void add(YamlNodePtr node, YAML::anchor_t anchor, int line) {
    if (anchor != 0) anchors_[anchor] = node;
    if (open_.empty()) {
      root = std::move(node);
      return;
    }
    if (expects_key()) {
      open_.back().key = YamlEntry{key_of(*node, line), line, nullptr};
      return;
    }
    YamlNode& parent = open_.back().node;
    parent.weight += node->weight;
    if (parent.weight > largest_tree)
      fail(line, "the file has too many values", "check for aliases that multiply values");
    if (parent.kind == YamlNode::Kind::list) {
      parent.items.push_back(std::move(node));
    } else {
      add_entry(std::move(node));
    }
  }

  std::string key_of(const YamlNode& node, int line) {
    if (node.kind == YamlNode::Kind::scalar && !node.text.empty()) return node.text;
    fail(line, "a key is missing before ':'", "write name: value");
  }

  /// Whether {k: 1,5 N/m} was read as the entry k: 1, and as a key "5 N/m" without a value.
  static bool has_decimal_comma(const YamlNode& map, const YamlEntry& entry) {
    const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    if (map.entries.empty() || entry.value->kind != YamlNode::Kind::null || !is_digit(entry.key.front())) return false;
    const auto& [key, line, value] = map.entries.back();
    return line == entry.line && value->kind == YamlNode::Kind::scalar && !value->text.empty() &&
           std::ranges::all_of(value->text, [&](char c) { return is_digit(c) || c == '-' || c == '+'; });
  }

  void add_entry(YamlNodePtr value) {
    Unfinished& map = open_.back();
    YamlEntry entry = *std::exchange(map.key, std::nullopt);
    entry.value = std::move(value);
    if (entry.key == "<<") {
      map.merged.push_back(entry.value);
    } else if (has_decimal_comma(map.node, entry)) {
      YamlEntry& cut = map.node.entries.back();
      const std::string number = cut.value->text + "," + entry.key;
      issues_.add({name_, entry.line}, "'" + cut.key + ": " + number + "' has a decimal comma",
                  "a comma separates the entries of a map",
                  "write the decimals with a point: " + cut.key + ": " + cut.value->text + "." + entry.key);
    } else if (const auto [first, is_new] = map.keys.emplace(entry.key, entry.line); !is_new) {
      issues_.add({name_, entry.line}, "'" + entry.key + "' is given twice",
                  "first on line " + std::to_string(first->second), "remove one of them");
    } else {
      map.node.entries.push_back(std::move(entry));
    }
  }

  /// The map's own keys take precedence over merged ones, earlier sources over later ones.
  void merge(const YamlNode& source, Unfinished& target) {
    if (source.kind == YamlNode::Kind::list)
      for (const auto& item : source.items) merge(*item, target);
    else if (source.kind != YamlNode::Kind::map)
      issues_.add({name_, target.node.line}, "<< is used on " + to_string(source), "only maps can be merged",
                  "write <<: *anchor_of_a_map");
    for (const auto& entry : source.entries)
      if (target.keys.emplace(entry.key, entry.line).second) target.node.entries.push_back(entry);
  }

  std::string expand(const std::string& value, int line) {
    try {
      return expand_environment(value, environment_);
    } catch (const InvalidInput& error) {
      issues_.add(error, {name_, line});
      return value;
    }
  }

  [[noreturn]] void fail(int line, const std::string& what, const std::string& fix) const {
    throw InvalidInput(Issue{{name_, line}, what, "", fix});
  }

  std::string name_;
  const Environment& environment_;
  IssueList& issues_;
  std::vector<Unfinished> open_;
  std::map<YAML::anchor_t, YamlNodePtr> anchors_;
};

void require_text(const std::string& text, const std::string& name) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t length = utf8_length(text, i);
    const bool control = (c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7F;
    if (length == 0 || control)
      throw InvalidInput(Issue{
          {name, line}, "not a text file in UTF-8", "it has a byte that is not valid text", "save the file as UTF-8"});
    if (c == '\n') ++line;
    i += length;
  }
}

}  // namespace

YamlNodePtr parse_yaml(const std::string& text, const std::string& name, const Environment& environment,
                       IssueList& issues) {
  require_text(text, name);
  TreeBuilder builder(name, environment, issues);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    const YamlNodePtr first = builder.root;
    if (parser.HandleNextDocument(builder))
      issues.add({name, builder.root ? builder.root->line : 0}, "a second document starts with ---",
                 "a case file must be one document", "remove it");
    builder.root = first;
  } catch (const YAML::Exception& error) {
    throw InvalidInput(yaml_mistake(text, name, std::max(1, error.mark.line + 1), error.msg));
  }
  if (!builder.root || builder.root->kind == YamlNode::Kind::null)
    throw InvalidInput(Issue{{name, 1}, "the file is empty", "", "write a case into it"});
  return builder.root;
}

std::string read_text_file(const std::string& file) {
  std::string text = read_bytes(file, largest_file + 1);
  if (text.size() > largest_file)
    throw InvalidInput(Issue{{file, 0}, "the file is too large for a case file", "", "keep data in separate files"});
  return text;
}

void raise_in_line_order(const IssueList& issues) {
  auto sorted = issues.issues();
  if (sorted.empty()) return;
  const std::string first_file = sorted.front().location.file;
  const auto place = [&](const Issue& issue) {
    const int line = issue.location.line > 0 ? issue.location.line : std::numeric_limits<int>::max();
    return std::pair(issue.location.file != first_file, line);
  };
  std::ranges::stable_sort(sorted, {}, place);
  throw InvalidInput(std::move(sorted));
}

}  // namespace kalfem
