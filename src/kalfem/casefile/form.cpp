#include "kalfem/casefile/form.hpp"

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
  const std::string range = bounds.describe();
  return range.empty() ? words : words + " " + range;
}

nlohmann::ordered_json whole_number(const FormSchema& scalar) {
  nlohmann::ordered_json json = scalar.json();
  json["type"] = "integer";
  return json;
}

double require_within(double value, const std::string& shown, const Bounds& bounds) {
  if (!bounds.contain(value)) throw InvalidInput(shown + " given", "it must be " + bounds.describe(), "");
  return value;
}

}  // namespace

bool Bounds::contain(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }

std::string Bounds::describe() const {
  const bool below = std::isfinite(low), above = std::isfinite(high);
  if (below && above)
    return std::string("in ") + (low_open ? "(" : "[") + shortest(low) + ", " + shortest(high) +
           (high_open ? ")" : "]");
  if (below) return (low_open ? "> " : ">= ") + shortest(low);
  if (above) return (high_open ? "< " : "<= ") + shortest(high);
  return "";
}

double checked_number(const std::string& text, const std::string& unit, const Bounds& bounds) {
  return require_within(to_si(text, unit), text, bounds);
}

double checked_number(const Located<Quantity>& given, const std::string& unit, const Bounds& bounds) {
  try {
    return require_within(to_si(given.value, unit), shortest(given.value.value), bounds);
  } catch (const InvalidInput& error) {
    std::vector<Issue> issues;
    for (const auto& each : error.issues()) issues.push_back(given.issue(each.what, each.why, each.fix));
    throw InvalidInput(std::move(issues));
  }
}

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

namespace form {

Form<double> number(std::string_view given_unit, const Bounds& bounds) {
  const std::string unit(given_unit);
  const auto parse = [=](const std::string& text) { return checked_number(text, unit, bounds); };
  auto form = scalar<double>(number_words(unit, bounds), parse, shortest, true);
  form.write = [=](double value) { return yaml_literal(shortest(value), unit_comment(unit)); };
  nlohmann::ordered_json json = form.schema.json();
  json["type"] = {"number", "string"};
  if (!unit_comment(unit).empty()) json["x-unit"] = unit;
  if (std::isfinite(bounds.low)) json[bounds.low_open ? "exclusiveMinimum" : "minimum"] = bounds.low;
  if (std::isfinite(bounds.high)) json[bounds.high_open ? "exclusiveMaximum" : "maximum"] = bounds.high;
  form.schema = FormSchema(std::move(json));
  return form;
}

Form<int> integer(int low, int high) {
  const auto parse = [=](const std::string& text) { return parse_whole(text, low, high); };
  const Bounds bounds{low == std::numeric_limits<int>::min() ? -std::numeric_limits<double>::infinity() : low,
                      high == std::numeric_limits<int>::max() ? std::numeric_limits<double>::infinity() : high};
  const std::string range = bounds.describe();
  auto form = scalar<int>(
      "whole number" + (range.empty() ? "" : " " + range), parse,
      [](const int& value) { return std::to_string(value); }, true);
  nlohmann::ordered_json json = whole_number(form.schema);
  if (low != std::numeric_limits<int>::min()) json["minimum"] = low;
  if (high != std::numeric_limits<int>::max()) json["maximum"] = high;
  form.schema = FormSchema(std::move(json));
  return form;
}

Form<std::uint64_t> seed() {
  const auto parse = [](const std::string& text) {
    return parse_whole<std::uint64_t>(text, 0, std::numeric_limits<std::uint64_t>::max());
  };
  auto form = scalar<std::uint64_t>(
      "whole number", parse, [](const std::uint64_t& value) { return std::to_string(value); }, true);
  nlohmann::ordered_json json = whole_number(form.schema);
  json["minimum"] = 0;
  form.schema = FormSchema(std::move(json));
  return form;
}

Form<bool> boolean() {
  const auto parse = [](const std::string& text) {
    if (text != "true" && text != "false") throw InvalidInput("'" + text + "' given", "", "write true or false");
    return text == "true";
  };
  auto form = scalar<bool>(
      "true | false", parse, [](const bool& value) { return std::string(value ? "true" : "false"); }, true);
  nlohmann::ordered_json json = form.schema.json();
  json["type"] = "boolean";
  form.schema = FormSchema(std::move(json));
  return form;
}

Form<std::string> text() {
  const auto same = [](const std::string& text) { return text; };
  return scalar<std::string>("text", same, same);
}

Form<Quantity> quantity() {
  const auto print = [](const Quantity& given) {
    return shortest(given.value) + (given.bare ? "" : " " + si_unit(given.dimension));
  };
  return scalar<Quantity>(
      "number with its unit", [](const std::string& text) { return parse_quantity(text); }, print, true);
}

Form<std::filesystem::path> path(bool existing) {
  namespace fs = std::filesystem;
  Form<fs::path> form;
  form.read = [=](const Cursor& cursor) -> std::optional<fs::path> {
    if (!cursor.require(YamlNode::Kind::scalar, "a file name")) return std::nullopt;
    std::error_code error;
    const fs::path file = fs::absolute(cursor.folder() / cursor.node().text, error).lexically_normal();
    if (!cursor.node().text.empty() && (!existing || fs::is_regular_file(file, error))) return file;
    cursor.issue("no file '" + file.string() + "'", "", "paths are relative to the case file");
    return std::nullopt;
  };
  form.write = [](const fs::path& file) { return yaml_text(file.string()); };
  form.schema = FormSchema({{"type", "string"}, {"x-written", "file name"}});
  return form;
}

bool require_size(const Cursor& list, std::size_t least, std::size_t most) {
  const std::size_t size = list.node().items.size();
  if (size >= least && size <= most) return true;
  const std::string wanted = least == most ? "" : size < least ? "at least " : "at most ";
  list.issue(std::to_string(size) + " values given", "",
             "give " + wanted + std::to_string(size < least ? least : most));
  return false;
}

void refuse_word(const std::string& word, const std::vector<std::string>& known, const FormSchema& schema) {
  throw InvalidInput("'" + word + "' is not known" + did_you_mean(word, known), "", "write one of " + schema.written());
}

Form<std::string> word(const std::vector<std::string>& known) {
  const FormSchema schema = choice_schema(known, std::vector<std::string>(known.size()));
  const auto parse = [=](const std::string& word) -> std::string {
    if (std::find(known.begin(), known.end(), word) == known.end()) refuse_word(word, known, schema);
    return word;
  };
  auto form = scalar<std::string>(schema.written(), parse, [](const std::string& word) { return word; });
  form.schema = schema;
  return form;
}

}  // namespace form
}  // namespace kalfem
