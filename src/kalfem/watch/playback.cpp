// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/playback.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "kalfem/base/units.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/record_source.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

namespace d = description;
using Json = nlohmann::ordered_json;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts{""};
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

double number_of(const std::string& text, const std::string& whole) try {
  std::size_t read = 0;
  const double value = std::stod(text, &read);
  if (read != text.size() || !std::isfinite(value)) throw std::invalid_argument(text);
  return value;
} catch (const std::exception&) {
  throw InvalidInput("--fault " + whole + ": '" + text + "' is no number", "",
                     "write KIND:CHANNEL:FROM[:TO[:VALUE]], times in seconds");
}

std::string unit_of(const d::Case& given, const d::Sensor& sensor) {
  if (!sensor.unit.value.empty()) return sensor.unit.value;
  return given.record ? given.record->unit.value : given.live ? given.live->value.unit.value : "";
}

}  // namespace

ScheduledFault scheduled_fault(const std::string& text) {
  static const std::map<std::string, FaultKind> kinds{
      {"dead", FaultKind::dead}, {"spike", FaultKind::spike}, {"offset", FaultKind::offset}, {"gap", FaultKind::gap}};
  const auto parts = parts_of(text);
  const auto kind = kinds.find(parts.front());
  if (kind == kinds.end() || parts.size() < 3 || parts.size() > 5)
    throw InvalidInput("--fault " + text + ": no fault is written like that", "kinds are dead, spike, offset and gap",
                       "write KIND:CHANNEL:FROM[:TO[:VALUE]], times in seconds");
  ScheduledFault fault{.kind = kind->second, .channel = parts[1], .from = number_of(parts[2], text)};
  fault.to = fault.kind == FaultKind::spike ? fault.from : std::numeric_limits<double>::infinity();
  if (parts.size() > 3 && !parts[3].empty()) fault.to = number_of(parts[3], text);
  const bool adds = fault.kind == FaultKind::spike || fault.kind == FaultKind::offset;
  if (adds && parts.size() < 5)
    throw InvalidInput("--fault " + text + ": the value is missing", "a " + parts.front() + " adds it",
                       "write KIND:CHANNEL:FROM:TO:VALUE, or KIND:CHANNEL:FROM::VALUE");
  if (parts.size() > 4) fault.value = number_of(parts[4], text);
  if (!(fault.to >= fault.from))
    throw InvalidInput("--fault " + text + ": it ends before it begins", "", "give FROM <= TO");
  return fault;
}

Index Playback::samples() const { return channels.empty() ? 0 : channels.front().values.size(); }

std::vector<std::string> Playback::lines(Index first, Index count) const {
  std::map<double, Json> by_delay;
  for (const auto& channel : channels) {
    auto& line = by_delay[channel.delay];
    if (line.is_null())
      line = {{"t", start + channel.delay + static_cast<double>(first) / sample_rate}, {"dt", 1.0 / sample_rate}};
    auto& values = line[channel.column] = Json::array();
    for (const double value : channel.values.segment(first, count))
      values.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  }
  std::vector<std::string> lines;
  for (const auto& [delay, line] : by_delay) lines.push_back(line.dump(-1, ' ', false, Json::error_handler_t::replace));
  return lines;
}

Playback playback_of(const Study& study, const Record& record) {
  const d::Case& given = *study.description;
  Playback playback{.sample_rate = record.sample_rate, .start = record.start};
  for (std::size_t i = 0; i < given.sensors.size(); ++i) {
    const auto& [name, sensor] = given.sensors[i];
    const auto calibration = calibration_of(name, sensor);
    const std::string unit = unit_of(given, sensor);
    const double factor = unit.empty() ? 1.0 : parse_unit_as(unit, study.sensors[i].unit).factor;
    const Eigen::VectorXd signal = record.values.row(record.find(name)).transpose();
    playback.channels.push_back({sensor.channel.value_or(name),
                                 (calibration.gain * signal.array() + calibration.offset) / factor, calibration.delay});
  }
  const auto& inputs = study.structure->parts.inputs;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto found =
        std::ranges::find(given.excitation, inputs[i].name, &std::pair<std::string, d::Excitation>::first);
    if (found == given.excitation.end() || found->second.unknown) continue;
    const auto* column = found->second.signal_as<d::FileSignal>();
    Eigen::VectorXd values =
        study.structure->signals[i]->sample(record.start, 1.0 / record.sample_rate, record.samples()).col(0).matrix();
    if (column) {
      values /= found->second.scale;
      if (!column->unit.value.empty()) values /= parse_unit(column->unit.value).factor;
    }
    playback.channels.push_back(
        {column ? column->channel.value : inputs[i].name, std::move(values), column ? column->delay : 0.0});
  }
  return playback;
}

void apply_faults(const std::vector<ScheduledFault>& faults, Playback& playback) {
  std::vector<std::string> known;
  for (const auto& channel : playback.channels) known.push_back(channel.column);
  for (const auto& fault : faults) {
    const auto channel = std::ranges::find(playback.channels, fault.channel, &PlayedChannel::column);
    if (channel == playback.channels.end())
      throw InvalidInput("--fault: there is no channel '" + fault.channel + "'" + did_you_mean(fault.channel, known),
                         "", "name a column that is published");
    const double last = static_cast<double>(playback.samples() - 1) / playback.sample_rate;
    const auto sample = [&](double time) {
      return static_cast<Index>(std::llround(std::clamp(time, 0.0, last) * playback.sample_rate));
    };
    const auto each_second = std::max<Index>(1, std::llround(playback.sample_rate));
    for (Index k = sample(fault.from); fault.from <= last && k <= sample(fault.to);
         k += fault.kind == FaultKind::spike ? each_second : 1) {
      double& value = channel->values[k];
      if (fault.kind == FaultKind::dead) value = fault.value;
      if (fault.kind == FaultKind::spike || fault.kind == FaultKind::offset) value += fault.value;
      if (fault.kind == FaultKind::gap) value = not_a_number;
    }
  }
}

}  // namespace kalfem
