// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/stream_line.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_columns = 10'000;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view spaces = " \t\r\n";
  const auto begin = text.find_first_not_of(spaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(spaces) - begin + 1);
}

/// Text for a message: its beginning.
std::string quoted(std::string_view text) {
  constexpr std::size_t shown = 40;
  return "'" + valid_utf8(text.substr(0, shown)) + (text.size() > shown ? "...'" : "'");
}

/// Nothing where it is no number; an empty place and nan are a missing value.
std::optional<double> number_of(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return not_a_number;
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return std::isfinite(value) ? value : not_a_number;
}

std::vector<std::string_view> places_of(std::string_view line) {
  std::vector<std::string_view> places;
  for (std::size_t begin = 0;;) {
    const auto end = line.find(',', begin);
    places.push_back(trimmed(line.substr(begin, end == std::string_view::npos ? end : end - begin)));
    if (end == std::string_view::npos || places.size() > most_columns) return places;
    begin = end + 1;
  }
}

double value_of(const std::string& name, const Json& given) {
  if (given.is_null()) return not_a_number;
  if (given.is_number()) return given.get<double>();
  throw InvalidInput("\"" + valid_utf8(name) + "\" holds something that is no number", "",
                     "write numbers, null where one is missing");
}

std::vector<StreamBlock> blocks_of_object(std::string_view line) {
  const Json object = Json::parse(line, nullptr, false);
  if (!object.is_object())
    throw InvalidInput("the line " + quoted(line) + " is no JSON object", "", "write {\"t\": 1.25, \"CHANNEL\": 0.3}");
  const auto time = object.find("t"), interval = object.find("dt");
  if (time == object.end() || !time->is_number() || !std::isfinite(time->get<double>()))
    throw InvalidInput("the line " + quoted(line) + " has no time", "samples are placed by it",
                       "write \"t\": the time of the first value in seconds");
  const bool has_interval = interval != object.end();
  if (has_interval && !(interval->is_number() && interval->get<double>() > 0.0))
    throw InvalidInput("\"dt\" is no time > 0", "it is that between two values",
                       "write it in seconds, or leave it out");
  const auto unit = object.find("unit");
  if (unit != object.end() && !unit->is_string())
    throw InvalidInput("\"unit\" is no text", "it is that of every channel of the line", "write \"unit\": \"g\"");
  std::vector<StreamBlock> blocks;
  for (const auto& [name, given] : object.items()) {
    if (name == "t" || name == "dt" || name == "unit") continue;
    StreamBlock block{.column = name, .time = time->get<double>()};
    if (unit != object.end()) block.unit = unit->get<std::string>();
    if (has_interval) block.interval = interval->get<double>();
    if (given.is_array())
      for (const auto& each : given) block.values.push_back(value_of(name, each));
    else
      block.values.push_back(value_of(name, given));
    blocks.push_back(std::move(block));
  }
  return blocks;
}

/// "a3 [g]": the name and the unit.
std::pair<std::string, std::string> title_of(std::string_view text) {
  const auto open = text.find_last_of("[(");
  const bool has_unit = open != std::string_view::npos && open > 0 && (text.back() == ']' || text.back() == ')');
  if (!has_unit) return {valid_utf8(text), ""};
  return {valid_utf8(trimmed(text.substr(0, open))), valid_utf8(text.substr(open + 1, text.size() - open - 2))};
}

}  // namespace

std::vector<StreamBlock> StreamLines::read(std::string_view line) {
  if (line.size() > longest_line)
    throw InvalidInput("a line of " + std::to_string(line.size()) + " bytes", "", "write fewer samples in a line");
  line = trimmed(line);
  if (line.empty()) return {};
  return line.front() == '{' ? blocks_of_object(line) : read_row(line);
}

std::vector<StreamBlock> StreamLines::read_row(std::string_view line) {
  const auto places = places_of(line);
  const auto time = number_of(places.front());
  if (!time) {
    if (places.size() < 2 || places.size() > most_columns)
      throw InvalidInput("the line " + quoted(line) + " is neither JSON nor CSV", "", "");
    columns_.clear();
    units_.clear();
    for (const auto place : places) {
      auto [name, unit] = title_of(place);
      columns_.push_back(std::move(name));
      units_.push_back(std::move(unit));
    }
    return {};
  }
  if (columns_.empty())
    throw InvalidInput("the line " + quoted(line) + " comes before the names of its columns", "",
                       "begin with a line such as t,a3,road");
  if (places.size() != columns_.size())
    throw InvalidInput("the line " + quoted(line) + " has " + std::to_string(places.size()) + " places",
                       "there are " + std::to_string(columns_.size()) + " columns", "");
  if (!std::isfinite(*time))
    throw InvalidInput("the line " + quoted(line) + " has no time", "samples are placed by it", "");
  std::vector<StreamBlock> blocks;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto value = number_of(places[i]);
    if (!value)
      throw InvalidInput(
          "the line " + quoted(line) + " has " + quoted(places[i]) + " in the column '" + columns_[i] + "'",
          "it is no number", "leave a place empty where a value is missing");
    blocks.push_back({.column = columns_[i], .unit = units_[i], .time = *time, .values = {*value}});
  }
  return blocks;
}

void StreamLines::keep(ArchiveWriter& archive) const {
  for (const auto* list : {&columns_, &units_}) archive.each(*list, [&](const std::string& text) { archive(text); });
}

void StreamLines::take_up(ArchiveReader& archive) {
  for (auto* list : {&columns_, &units_}) archive.each(*list, [&](std::string& text) { archive(text); });
}

}  // namespace kalfem
