// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/inspection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "kalfem/base/units.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double visible_jitter = 0.01;  ///< of the interval

std::string stretches(Index count) { return fmt::format("{} stretch{}", count, count == 1 ? "" : "es"); }

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? four_digits(value) : four_digits(value) + " " + unit;
}

std::string at_time(const ChannelStatistics& statistics, const MeasuredChannel& channel, Index sample) {
  if (channel.times.size() > sample) return four_digits(channel.times[sample]) + " s";
  if (!(channel.interval > 0.0)) return fmt::format("sample {}", sample + 1);
  return four_digits(statistics.time.start + channel.interval * static_cast<double>(sample)) + " s";
}

std::string dead_words(const MeasuredChannel& channel, const ChannelStatistics& found) {
  switch (found.dead) {
    case DeadReason::no_samples:
      return "has no samples";
    case DeadReason::no_numbers:
      return "has no number in " + counted(found.samples, "sample");
    case DeadReason::constant:
      return "dead: " + with_unit(found.lowest, channel.unit) + " throughout";
    case DeadReason::two_levels:
      return "dead: it flickers between " + with_unit(found.lowest, channel.unit) + " and " +
             with_unit(found.highest, channel.unit);
    case DeadReason::none:
      break;
  }
  return {};
}

void add_clipping(const std::optional<Clipping>& clipping, const char* side, const std::string& unit,
                  std::vector<std::string>& words) {
  if (clipping)
    words.push_back(fmt::format("clipped {} at {}: {} there, in {}", side, with_unit(clipping->level, unit),
                                counted(clipping->samples, "sample"), stretches(clipping->times)));
}

void add_time_findings(const TimeBase& time, std::vector<std::string>& words) {
  if (time.gaps > 0)
    words.push_back(fmt::format("{} in time: about {} missing, the longest lasts {} s", counted(time.gaps, "gap"),
                                counted(time.missing, "sample"), four_digits(time.longest_gap)));
  if (time.not_increasing > 0)
    words.push_back(
        fmt::format("{} not behind the one before",
                    time.not_increasing == 1 ? "1 time is" : std::to_string(time.not_increasing) + " times are"));
  if (time.jitter > visible_jitter)
    words.push_back(fmt::format("uneven times: intervals deviate by {} % (rms), {} % at most",
                                four_digits(100.0 * time.jitter), four_digits(100.0 * time.worst)));
}

}  // namespace

Inspection inspect(std::string file, MeasuredFile content) {
  Inspection inspection{std::move(file), std::move(content), {}};
  for (const auto& channel : inspection.content.channels) inspection.channels.push_back(statistics_of(channel));
  return inspection;
}

std::vector<std::string> findings_of(const MeasuredChannel& channel, const ChannelStatistics& found) {
  std::vector<std::string> words;
  if (found.dead != DeadReason::none) words.push_back(dead_words(channel, found));
  add_clipping(found.clipped_above, "above", channel.unit, words);
  add_clipping(found.clipped_below, "below", channel.unit, words);
  if (found.missing > 0 && found.dead != DeadReason::no_numbers)
    words.push_back(fmt::format("{} missing in {}, at most {} in a row", counted(found.missing, "sample"),
                                stretches(found.missing_stretches), found.longest_missing));
  add_time_findings(found.time, words);
  if (found.hold)
    words.push_back(fmt::format("sticks at {} for {} from {}",
                                with_unit(channel.values[found.hold->first], channel.unit),
                                counted(found.hold->samples, "sample"), at_time(found, channel, found.hold->first)));
  if (found.drifts())
    words.push_back(fmt::format("drifts by {} over the record ({} % of its variance)",
                                with_unit(found.drift, channel.unit), four_digits(100.0 * found.drift_share)));
  return words;
}

std::string place_text(const MeasuredPlace& place) {
  constexpr const char* axes[] = {"", "x", "y", "z", "rx", "ry", "rz"};
  const int axis = std::abs(place.direction);
  std::string text = place.node ? std::to_string(*place.node) : "";
  if (axis >= 1 && axis <= 6)
    text += fmt::format("{}{}{}", text.empty() ? "" : " ", place.direction < 0 ? '-' : '+', axes[axis]);
  return text;
}

std::string frequencies_text(const ChannelStatistics& found) {
  std::string text;
  for (const auto& peak : found.frequencies) text += (text.empty() ? "" : ", ") + four_digits(peak.frequency);
  return text.empty() ? "-" : text;
}

namespace {

std::string known(double value) { return value > 0.0 ? four_digits(value) : "-"; }

Table channel_table(const Inspection& inspection) {
  Table table{"Channels",
              {"channel", "unit", "quantity", "place", "samples", "rate [Hz]", "start [s]", "duration [s]", "offset",
               "rms", "peak", "frequencies [Hz]"},
              {},
              {Align::left, Align::left, Align::left, Align::left, Align::right, Align::right, Align::right,
               Align::right, Align::right, Align::right, Align::right, Align::left}};
  for (std::size_t i = 0; i < inspection.channels.size(); ++i) {
    const auto& channel = inspection.content.channels[i];
    const auto& found = inspection.channels[i];
    table.rows.push_back({channel.name, channel.unit, channel.quantity, place_text(channel.place),
                          std::to_string(found.samples), known(found.time.rate), four_digits(found.time.start),
                          known(found.time.duration), four_digits(found.offset), four_digits(found.rms),
                          four_digits(found.peak), frequencies_text(found)});
  }
  return table;
}

const char* kind_words(MeasuredFunctionKind kind) {
  switch (kind) {
    case MeasuredFunctionKind::frequency_response:
      return "frequency response";
    case MeasuredFunctionKind::coherence:
      return "coherence";
    case MeasuredFunctionKind::auto_spectrum:
      return "auto spectrum";
    case MeasuredFunctionKind::cross_spectrum:
      return "cross spectrum";
    case MeasuredFunctionKind::other:
      break;
  }
  return "function of frequency";
}

Table function_table(const MeasuredFile& content) {
  Table table{"Functions of frequency",
              {"function", "kind", "unit", "response", "reference", "lines", "from [Hz]", "to [Hz]"},
              {},
              {}};
  for (const auto& each : content.functions) {
    const Index last = each.lines.size() - 1;
    table.rows.push_back({each.name, kind_words(each.kind), each.unit, place_text(each.response),
                          place_text(each.reference), std::to_string(each.values.size()),
                          last < 0 ? "-" : four_digits(each.lines[0]), last < 0 ? "-" : four_digits(each.lines[last])});
  }
  return table;
}

Table shape_table(const MeasuredFile& content) {
  Table table{"Shapes", {"shape", "frequency [Hz]", "damping [%]", "nodes"}, {}, {}};
  for (const auto& each : content.shapes)
    table.rows.push_back(
        {each.name, four_digits(each.frequency), four_digits(100.0 * each.damping), std::to_string(each.nodes.size())});
  return table;
}

std::vector<Table> tables_of(const Inspection& inspection) {
  std::vector<Table> tables{channel_table(inspection), function_table(inspection.content),
                            shape_table(inspection.content)};
  std::erase_if(tables, [](const Table& table) { return table.rows.empty(); });
  return tables;
}

/// Of the file, then of every channel, "a3: clipped above at ...".
std::vector<std::string> all_findings(const Inspection& inspection) {
  std::vector<std::string> all = inspection.content.notes;
  for (std::size_t i = 0; i < inspection.channels.size(); ++i)
    for (const auto& words : findings_of(inspection.content.channels[i], inspection.channels[i]))
      all.push_back(inspection.content.channels[i].name + ": " + words);
  return all;
}

std::string listed(const char* title, const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += (text.empty() ? std::string(title) + "\n" : "") + "  " + line + "\n";
  return text.empty() ? text : text + "\n";
}

std::string contents_words(const MeasuredFile& content) {
  std::string text = content.format;
  const auto add = [&](std::size_t count, const std::string& thing) {
    if (count > 0) text += ", " + counted(static_cast<Index>(count), thing);
  };
  add(content.channels.size(), "channel");
  add(content.functions.size(), "function");
  add(content.shapes.size(), "shape");
  add(content.nodes.size(), "node");
  return text;
}

}  // namespace

std::string inspection_text(const Inspection& inspection) {
  std::string text = inspection.file + ": " + contents_words(inspection.content) + "\n\n";
  for (const auto& table : tables_of(inspection)) text += to_text(table) + "\n";
  text += listed("Findings", all_findings(inspection));
  return text + listed("Not read", inspection.content.skipped);
}

namespace {

using Json = nlohmann::ordered_json;

Json known_number(double value) { return value > 0.0 ? number(value) : Json(nullptr); }

Json place_json(const MeasuredPlace& place) {
  return {{"node", place.node ? Json(*place.node) : Json(nullptr)}, {"direction", place.direction}};
}

Json clipping_json(const std::optional<Clipping>& clipping) {
  if (!clipping) return nullptr;
  return {{"level", number(clipping->level)}, {"samples", clipping->samples}, {"times", clipping->times}};
}

Json time_json(const TimeBase& time) {
  return {{"rate_hz", known_number(time.rate)},
          {"start_s", number(time.start)},
          {"duration_s", known_number(time.duration)},
          {"jitter", number(time.jitter)},
          {"largest_jitter", number(time.worst)},
          {"gaps", time.gaps},
          {"missing", time.missing},
          {"longest_gap_s", number(time.longest_gap)},
          {"not_increasing", time.not_increasing}};
}

Json channel_json(const MeasuredChannel& channel, const ChannelStatistics& found) {
  Json json{{"name", channel.name},
            {"unit", channel.unit},
            {"quantity", channel.quantity},
            {"description", channel.description},
            {"place", place_json(channel.place)},
            {"samples", found.samples},
            {"time", time_json(found.time)},
            {"lowest", number(found.lowest)},
            {"highest", number(found.highest)},
            {"offset", number(found.offset)},
            {"rms", number(found.rms)},
            {"peak", number(found.peak)},
            {"drift", number(found.drift)},
            {"drift_share", number(found.drift_share)},
            {"missing", found.missing},
            {"missing_stretches", found.missing_stretches},
            {"longest_missing", found.longest_missing},
            {"dead", found.dead != DeadReason::none},
            {"clipped_above", clipping_json(found.clipped_above)},
            {"clipped_below", clipping_json(found.clipped_below)},
            {"held", found.hold ? Json{{"first", found.hold->first}, {"samples", found.hold->samples}} : Json(nullptr)},
            {"frequencies", Json::array()}};
  for (const auto& peak : found.frequencies)
    json["frequencies"].push_back({{"frequency_hz", number(peak.frequency)}, {"share", number(peak.share)}});
  json["findings"] = findings_of(channel, found);
  return json;
}

}  // namespace

Json inspection_json(const Inspection& inspection) {
  const auto& content = inspection.content;
  Json json{{"file", inspection.file},    {"format", content.format},  {"channels", Json::array()},
            {"functions", Json::array()}, {"shapes", Json::array()},   {"nodes", content.nodes.size()},
            {"notes", content.notes},     {"skipped", content.skipped}};
  for (std::size_t i = 0; i < inspection.channels.size(); ++i)
    json["channels"].push_back(channel_json(content.channels[i], inspection.channels[i]));
  for (const auto& each : content.functions)
    json["functions"].push_back({{"name", each.name},
                                 {"kind", kind_words(each.kind)},
                                 {"unit", each.unit},
                                 {"response", place_json(each.response)},
                                 {"reference", place_json(each.reference)},
                                 {"lines", each.values.size()}});
  for (const auto& each : content.shapes)
    json["shapes"].push_back({{"name", each.name},
                              {"frequency_hz", number(each.frequency)},
                              {"damping", number(each.damping)},
                              {"nodes", each.nodes.size()}});
  return json;
}

namespace {

/// The course over time; over the number of the sample where times are unknown or do not increase.
Chart chart_of(const MeasuredChannel& channel, const TimeBase& time) {
  const Index count = channel.values.size();
  const bool stamped = channel.times.size() == count && time.not_increasing == 0;
  const bool timed = stamped || (channel.times.size() == 0 && channel.interval > 0.0);
  std::vector<double> x(static_cast<std::size_t>(count));
  for (Index k = 0; k < count; ++k)
    x[static_cast<std::size_t>(k)] = stamped ? channel.times[k]
                                     : timed ? channel.start + channel.interval * static_cast<double>(k)
                                             : static_cast<double>(k + 1);
  return {
      .title = channel.name,
      .x_label = timed ? "time [s]" : "sample",
      .y_label = channel.unit.empty() ? channel.name : channel.name + " [" + channel.unit + "]",
      .x = std::move(x),
      .series = {{.label = channel.name, .y = {channel.values.begin(), channel.values.end()}, .role = Role::measured}},
      .half_width = true};
}

Section section_of(const Inspection& inspection) {
  Section section{.heading = std::filesystem::path(inspection.file).filename().string(),
                  .text = contents_words(inspection.content)};
  for (auto& table : tables_of(inspection)) section.items.emplace_back(std::move(table));
  Table findings{"Findings", {"finding"}, {}, {Align::left}}, skipped{"Not read", {"part"}, {}, {Align::left}};
  for (const auto& words : all_findings(inspection)) findings.rows.push_back({words});
  for (const auto& words : inspection.content.skipped) skipped.rows.push_back({words});
  for (auto* table : {&findings, &skipped})
    if (!table->rows.empty()) section.items.emplace_back(std::move(*table));
  for (std::size_t i = 0; i < inspection.channels.size(); ++i)
    if (inspection.channels[i].samples > 1)
      section.items.emplace_back(chart_of(inspection.content.channels[i], inspection.channels[i].time));
  return section;
}

}  // namespace

Page inspection_page(const std::vector<Inspection>& inspections) {
  Page page{.title = inspections.size() == 1 ? std::filesystem::path(inspections.front().file).filename().string()
                                             : fmt::format("{} measured files", inspections.size()),
            .subtitle = "What the files of the test bench hold"};
  std::size_t findings = 0;
  for (const auto& inspection : inspections) {
    findings += all_findings(inspection).size();
    page.sections.push_back(section_of(inspection));
  }
  if (findings > 0) page.status = VerdictState::suspicious;
  page.summary = findings == 0 ? "Nothing odd was found." : counted(static_cast<Index>(findings), "finding") + ".";
  return page;
}

}  // namespace kalfem
