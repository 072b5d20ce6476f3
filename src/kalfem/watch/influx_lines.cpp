// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/influx_lines.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace kalfem {
namespace {

using Json = nlohmann::json;
using Pairs = std::vector<std::pair<std::string, std::string>>;

/// With what has a meaning in the protocol escaped.
std::string escaped(const std::string& text, std::string_view special) {
  std::string safe;
  for (const char c : text) {
    if (c == '\n' || c == '\r') continue;
    if (special.find(c) != std::string_view::npos) safe += '\\';
    safe += c;
  }
  return safe;
}

std::string tag(const std::string& text) { return escaped(text, ", ="); }
std::string quoted(const std::string& text) { return '"' + escaped(text, "\"\\") + '"'; }

/// One line; none without fields or a time.
std::string line_of(const std::string& measurement, const Pairs& tags, const Pairs& fields, const Json& time) {
  if (fields.empty() || !time.is_number()) return {};
  std::string line = measurement;
  for (const auto& [key, value] : tags)
    if (!value.empty()) line += "," + key + "=" + tag(value);
  char mark = ' ';
  for (const auto& [key, value] : fields) {
    line += mark + key + "=" + value;
    mark = ',';
  }
  return line + " " + std::to_string(std::llround(time.get<double>() * 1e9)) + "\n";
}

/// The numbers of an object by these keys; what is none is left out.
Pairs numbers(const Json& object, std::initializer_list<const char*> keys, const char* ending = "") {
  Pairs fields;
  for (const char* key : keys)
    if (const auto found = object.find(key); found != object.end() && found->is_number())
      fields.emplace_back(key, found->dump() + ending);
  return fields;
}

/// Parameters and outputs of `told`, as measurements of these names with an ending.
std::string values_of(const Json& told, const std::string& name, const std::string& ending) {
  const Json& time = told.at("t");
  std::string lines;
  for (const auto& [parameter, value] : told.at("parameters").items())
    lines +=
        line_of("kalfem_parameter" + ending, {{"case", name}, {"parameter", parameter}, {"unit", value.at("unit")}},
                numbers(value, {"estimate", "std"}), time);
  for (const auto& [output, value] : told.at("outputs").items())
    lines +=
        line_of("kalfem_output" + ending, {{"case", name}, {"output", output}}, numbers(value, {"mean", "std"}), time);
  return lines;
}

std::string estimates_of(const Json& told, const std::string& name) {
  Pairs state = numbers(told, {"samples", "late", "bad_lines"}, "i");
  for (const char* key : {"condition", "verdict"}) state.emplace_back(key, quoted(told.at(key)));
  std::string lines = line_of("kalfem", {{"case", name}}, state, told.at("t")) + values_of(told, name, "");
  if (const auto smoothed = told.find("smoothed"); smoothed != told.end())
    lines += values_of(*smoothed, name, "_smoothed");
  return lines;
}

std::string alarm_of(const Json& told, const std::string& name) {
  Pairs fields = numbers(told, {"change", "std", "lower", "upper", "since", "statistic"});
  fields.emplace_back("text", quoted(told.at("text")));
  return line_of("kalfem_alarm", {{"case", name}, {"parameter", told.at("parameter")}, {"kind", told.at("kind")}},
                 fields, told.at("t"));
}

std::string trend_of(const Json& told, const std::string& name) {
  std::string lines;
  for (const auto& [parameter, value] : told.at("parameters").items()) {
    Pairs fields = numbers(value, {"mean", "std", "lower", "upper"});
    for (auto& [key, number] : numbers(value.at("corrected"), {"mean", "std", "lower", "upper"}))
      fields.emplace_back("corrected_" + key, number);
    lines += line_of("kalfem_trend", {{"case", name}, {"parameter", parameter}, {"unit", value.at("unit")}}, fields,
                     told.at("day"));
  }
  return lines;
}

}  // namespace

std::string influx_lines(MessageKind kind, const std::string& line, const std::string& name) {
  const Json told = Json::parse(line);
  if (kind == MessageKind::alarm) return alarm_of(told.at("alarm"), name);
  if (kind == MessageKind::trend) return trend_of(told.at("trend"), name);
  return estimates_of(told, name);
}

}  // namespace kalfem
