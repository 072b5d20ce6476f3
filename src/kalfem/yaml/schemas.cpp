// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/schemas.hpp"

#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>

namespace kalfem {
namespace {

template <class Integer>
Integer parse_whole(const std::string& text, Integer low, Integer high) {
  Integer value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  if (!whole || value < low || value > high)
    throw InvalidInput("'" + text + "' given", "",
                       "write a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return value;
}

std::string unit_comment(const std::string& unit) { return unit == "-" ? "" : unit; }

/// "number [m/s^2] > 0"
std::string number_words(const std::string& unit, const Bounds& bounds) {
  std::string words = "number";
  if (!unit_comment(unit).empty()) words += " [" + unit + "]";
  const std::string range = bounds.to_string();
  return range.empty() ? words : words + " " + range;
}

nlohmann::ordered_json whole_number(const std::string& words) {
  nlohmann::ordered_json json = scalar_schema(words).json();
  json["type"] = "integer";
  return json;
}

/// A schema with another description of the same text.
class RestatedSchema final : public AnySchema {
public:
  RestatedSchema(AnySchemaPtr schema, const std::string& words)
      : AnySchema(schema->json_schema.written_as(words)), schema_(std::move(schema)) {}
  bool read(const CaseNode& node, void* value) const override { return schema_->read(node, value); }
  YamlNodePtr write(const void* value) const override { return schema_->write(value); }

private:
  AnySchemaPtr schema_;
};

/// A short schema for scalars and a full one for lists and maps.
class ShortOrFullSchema final : public AnySchema {
public:
  ShortOrFullSchema(AnySchemaPtr short_schema, AnySchemaPtr full_schema)
      : AnySchema(either_schema(short_schema->json_schema, full_schema->json_schema)),
        short_(std::move(short_schema)),
        full_(std::move(full_schema)) {}
  bool read(const CaseNode& node, void* value) const override {
    return (node.yaml().kind == YamlNode::Kind::scalar ? short_ : full_)->read(node, value);
  }
  YamlNodePtr write(const void* value) const override { return full_->write(value); }

private:
  AnySchemaPtr short_, full_;
};

}  // namespace

void require_name(const std::string& name, NameRule rule) {
  const auto belongs = [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ||
           (c == '.' && rule == NameRule::dotted);
  };
  const bool dots_between =
      !name.empty() && name.front() != '.' && name.back() != '.' && name.find("..") == std::string::npos;
  if (!dots_between || name.size() > 100 || !std::all_of(name.begin(), name.end(), belongs))
    throw InvalidInput(
        "the name cannot be used", "",
        rule == NameRule::name ? "use letters, digits, _ and -" : "use names joined by dots, like suspension.k");
}

namespace schema {

Schema<double> number(std::string_view given_unit, const Bounds& bounds) {
  const std::string unit(given_unit);
  nlohmann::ordered_json json = scalar_schema(number_words(unit, bounds)).json();
  json["type"] = {"number", "string"};
  if (!unit_comment(unit).empty()) json["x-unit"] = unit;
  if (std::isfinite(bounds.low)) json[bounds.low_open ? "exclusiveMinimum" : "minimum"] = bounds.low;
  if (std::isfinite(bounds.high)) json[bounds.high_open ? "exclusiveMaximum" : "maximum"] = bounds.high;
  return scalar<double>(
      JsonSchema(std::move(json)), [=](const std::string& text) { return checked_number(text, unit, bounds); },
      [=](double value) { return yaml_literal(shortest(value), unit_comment(unit)); });
}

Schema<int> integer(int low, int high) {
  const Bounds bounds{low == std::numeric_limits<int>::min() ? -std::numeric_limits<double>::infinity() : low,
                      high == std::numeric_limits<int>::max() ? std::numeric_limits<double>::infinity() : high};
  const std::string range = bounds.to_string();
  nlohmann::ordered_json json = whole_number("whole number" + (range.empty() ? "" : " " + range));
  if (low != std::numeric_limits<int>::min()) json["minimum"] = low;
  if (high != std::numeric_limits<int>::max()) json["maximum"] = high;
  return scalar<int>(
      JsonSchema(std::move(json)), [=](const std::string& text) { return parse_whole(text, low, high); },
      [](int value) { return yaml_literal(std::to_string(value)); });
}

Schema<std::uint64_t> seed() {
  nlohmann::ordered_json json = whole_number("whole number");
  json["minimum"] = 0;
  return scalar<std::uint64_t>(
      JsonSchema(std::move(json)),
      [](const std::string& text) {
        return parse_whole<std::uint64_t>(text, 0, std::numeric_limits<std::uint64_t>::max());
      },
      [](std::uint64_t value) { return yaml_literal(std::to_string(value)); });
}

Schema<bool> boolean() {
  const auto parse = [](const std::string& text) {
    if (text != "true" && text != "false") throw InvalidInput("'" + text + "' given", "", "write true or false");
    return text == "true";
  };
  nlohmann::ordered_json json = scalar_schema("true | false").json();
  json["type"] = "boolean";
  return scalar<bool>(JsonSchema(std::move(json)), parse,
                      [](bool value) { return yaml_literal(value ? "true" : "false"); });
}

Schema<std::string> text() {
  return scalar<std::string>(
      scalar_schema("text"), [](const std::string& text) { return text; },
      [](const std::string& text) { return yaml_text(text); });
}

namespace {

/// "15 %" of 0.15: in as many digits as read back as the same number.
std::string per_cent_text(double value) {
  std::array<char, 32> rounded{};
  std::snprintf(rounded.data(), rounded.size(), "%.15g %%", 100.0 * value);
  const std::string text = rounded.data();
  return parse_quantity(text).value == value ? text : shortest(100.0 * value) + " %";
}

}  // namespace

Schema<Quantity> quantity() {
  const auto write = [](const Quantity& given) {
    if (given.per_cent) return yaml_literal(per_cent_text(given.value));
    return yaml_literal(shortest(given.value) + (given.bare ? "" : " " + si_unit(given.dimension)));
  };
  return scalar<Quantity>(
      scalar_schema("number with its unit"), [](const std::string& text) { return parse_quantity(text); }, write);
}

Schema<std::filesystem::path> path(bool existing) {
  namespace fs = std::filesystem;
  const auto read = [=](const CaseNode& node, fs::path& file) {
    if (!node.require(YamlNode::Kind::scalar, "a file name")) return false;
    std::error_code error;
    file = fs::absolute(node.folder() / node.yaml().text, error).lexically_normal();
    if (!node.yaml().text.empty() && (!existing || fs::is_regular_file(file, error))) {
      if (existing) node.add_file(file);
      return true;
    }
    node.issue("no file '" + file.string() + "'", "", "paths are relative to the case file");
    return false;
  };
  return make_schema<fs::path>(
      read, [](const fs::path& file) { return yaml_text(file.string()); },
      JsonSchema({{"type", "string"}, {"x-written", "file name"}}));
}

AnySchemaPtr restated(const AnySchemaPtr& schema, const std::string& words) {
  return std::make_shared<const RestatedSchema>(schema, words);
}

AnySchemaPtr short_or_full(const AnySchemaPtr& short_schema, const AnySchemaPtr& full_schema) {
  return std::make_shared<const ShortOrFullSchema>(short_schema, full_schema);
}

bool require_size(const CaseNode& list, std::size_t least, std::size_t most) {
  const std::size_t size = list.yaml().items.size();
  if (size >= least && size <= most) return true;
  const std::string wanted = least == most ? "" : size < least ? "at least " : "at most ";
  list.issue(std::to_string(size) + " values given", "",
             "give " + wanted + std::to_string(size < least ? least : most));
  return false;
}

Schema<std::size_t> one_of_words(const std::vector<std::string>& words, const std::vector<std::string>& meanings) {
  const JsonSchema json_schema = choice_schema(words, meanings);
  const auto parse = [=](const std::string& word) {
    const auto found = std::find(words.begin(), words.end(), word);
    if (found == words.end())
      throw InvalidInput("'" + word + "' is not known" + did_you_mean(word, words), "",
                         "write one of " + json_schema.written());
    return static_cast<std::size_t>(found - words.begin());
  };
  return scalar<std::size_t>(json_schema, parse,
                             [=](std::size_t i) { return yaml_text(i < words.size() ? words[i] : std::string()); });
}

Schema<std::string> word(const std::vector<std::string>& known) {
  const auto number = one_of_words(known, std::vector<std::string>(known.size()));
  const auto read = [=](const CaseNode& node, std::string& word) {
    std::size_t chosen = 0;
    if (!number.read(node, chosen)) return false;
    word = known[chosen];
    return true;
  };
  return make_schema<std::string>(
      read, [](const std::string& word) { return yaml_text(word); }, number.json_schema());
}

}  // namespace schema
}  // namespace kalfem
