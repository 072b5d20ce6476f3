// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/case_edit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/system/sensors/output_description.hpp"

namespace kalfem {
namespace {

constexpr int digits = 4;  ///< of numbers in an edit

std::string number(double value) { return fmt::format("{:.{}g}", value, digits); }

std::string with_unit(double value, const std::string& unit) {
  const DisplayUnit shown(unit, {value});
  return shown.value(value) + (shown.unit() == "-" ? "" : " " + shown.unit());
}

/// The names of "a3, a5".
std::vector<std::string> names_in(const std::string& subject) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= subject.size();) {
    const auto end = std::min(subject.find(", ", begin), subject.size());
    names.push_back(subject.substr(begin, end - begin));
    begin = end + 2;
  }
  return names;
}

/// Edits of the channels of a measured record.
class ChannelEdits {
public:
  ChannelEdits(const TestedHypothesis& cause, const Study& study, const EstimationOutcome& outcome)
      : cause_(cause), study_(study), outcome_(outcome) {}

  std::vector<std::string> lines() const {
    const auto names = names_in(cause_.subject);
    if (cause_.code == "sensors_swapped") return exchanged(names);
    std::vector<std::string> lines;
    for (const auto& name : names) {
      const auto* sensor = sensor_named(name);
      if (!sensor) return {};
      const std::string keys = edit_of(name, *sensor);
      if (keys.empty()) return {};
      lines.push_back(name + ": {" + keys + "}");
    }
    return lines;
  }

private:
  [[nodiscard]] const description::Sensor* sensor_named(const std::string& name) const {
    const auto found =
        std::ranges::find(study_.description->sensors, name, [](const auto& each) { return each.first; });
    return found == study_.description->sensors.end() ? nullptr : &found->second;
  }

  /// The channel holds gain signal + offset, late by delay + drift t. What was corrected is the signal that the case's
  /// own numbers leave.
  [[nodiscard]] std::string edit_of(const std::string& name, const description::Sensor& sensor) const {
    const std::string& code = cause_.code;
    if (code == "sensor_sign") return "gain: " + number(-sensor.gain);
    if (code == "sensor_gain" || code == "sensor_unit")
      return "gain: " + number((cause_.turned ? -1.0 : 1.0) * cause_.value * sensor.gain);
    if (code == "sensor_delay")
      return "delay: " + with_unit(sensor.delay + cause_.value / outcome_.measurements.sample_rate, "s");
    const bool late_besides = cause_.fitted > 1;  // by a delay that no key of this edit would hold
    if (code == "sensor_drift" && !late_besides)
      return fmt::format("drift: {} ppm", number(1e6 * (sensor.drift + cause_.value)));
    const auto& channels = outcome_.measurements.channels;
    const auto channel = std::ranges::find(channels, name, &Channel::name);
    if (channel == channels.end()) return "";
    if (code == "sensor_noise") return "noise: " + with_unit(channel->noise * cause_.value, channel->unit);
    if (code != "sensor_offset" || sensor.offset) return "";
    return "offset: " + with_unit(sensor.gain * cause_.value, channel->unit);
  }

  /// Each takes the column of the other.
  [[nodiscard]] std::vector<std::string> exchanged(const std::vector<std::string>& names) const {
    if (names.size() != 2) return {};
    const auto *one = sensor_named(names[0]), *other = sensor_named(names[1]);
    if (!one || !other || one->file || other->file || one->unit.value != other->unit.value) return {};
    return {fmt::format("{}: {{channel: {}}}", names[0], other->channel.value_or(names[1])),
            fmt::format("{}: {{channel: {}}}", names[1], one->channel.value_or(names[0]))};
  }

  const TestedHypothesis& cause_;
  const Study& study_;
  const EstimationOutcome& outcome_;
};

std::string connector_line(const LackingForce& force) {
  std::string line = fmt::format("{}: {{from: {}, to: {}, law: expression, force: \"{}\", parameters: {{K: {}",
                                 force.name, force.from, force.to, force.force, number(force.factor));
  if (force.place) line += ", s: " + number(*force.place);
  line += "}";
  for (const auto& [name, rate] : force.states)
    line += fmt::format(", states: {{{}: {{rate: \"{}\", unit: m}}}}", name, rate);
  return line + "}";
}

void add_first_guess(const TestedHypothesis& cause, const Study& study, CaseEdit& edit) {
  const auto& unknowns = study.problem->settings.unknowns;
  const auto unknown = std::ranges::find(unknowns, cause.subject, &Unknown::name);
  if (unknown == unknowns.end()) return;
  edit.unknowns.push_back(fmt::format("{}: {{initial: {}, std: {}}}", unknown->name,
                                      with_unit(cause.value * unknown->initial, unknown->unit()),
                                      with_unit(cause.value * unknown->deviation, unknown->unit())));
}

void append(const std::vector<std::string>& lines, const std::string& heading, const std::string& indent,
            std::string& text) {
  if (lines.empty()) return;
  text += heading;
  for (const auto& line : lines) text += indent + line + "\n";
}

}  // namespace

void CaseEdit::add(const CaseEdit& other) {
  connectors.insert(connectors.end(), other.connectors.begin(), other.connectors.end());
  sensors.insert(sensors.end(), other.sensors.begin(), other.sensors.end());
  unknowns.insert(unknowns.end(), other.unknowns.begin(), other.unknowns.end());
}

std::string CaseEdit::yaml() const {
  std::string text;
  append(connectors, "connectors:\n", "  ", text);
  append(sensors, "sensors:\n", "  ", text);
  append(unknowns, "estimate:\n  unknown:\n", "    ", text);
  return text;
}

CaseEdit edit_against(const TestedHypothesis& cause, const Study& study, const EstimationOutcome& outcome) {
  CaseEdit edit;
  for (const auto& force : cause.forces) {
    edit.connectors.push_back(connector_line(force));
    edit.unknowns.push_back(
        fmt::format("{}.K: {{initial: {}, std: {}}}", force.name, number(force.factor), number(force.deviation)));
  }
  if (cause.code == "first_guess") add_first_guess(cause, study, edit);
  if (cause.code.starts_with("sensor") && study.record) edit.sensors = ChannelEdits(cause, study, outcome).lines();
  return edit;
}

}  // namespace kalfem
