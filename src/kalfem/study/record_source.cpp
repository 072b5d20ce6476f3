// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/record_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kalfem/base/units.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/formats/measured_selection.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/records/channel_calibration.hpp"
#include "kalfem/records/oversampling.hpp"
#include "kalfem/system/sensors/output_map.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

using description::Observed;
using Eigen::Index;

void check_finite(const Record& record, const description::Record& asked) {
  if (asked.skip_missing || asked.repair_splice || record.values.allFinite()) return;
  IssueList issues;
  for (Index j = 0; j < record.values.rows(); ++j)
    for (Index k = 0; k < record.samples(); ++k)
      if (!std::isfinite(record.values(j, k))) {
        issues.add({asked.file.value.string(), 0},
                   "channel '" + record.channels[static_cast<std::size_t>(j)].name + "' is not a number at " +
                       shortest(record.time(k)) + " s",
                   "the filter needs a number at every sample", "set record.skip_missing: true to skip such samples");
        break;
      }
  issues.raise();
}

SourceLocation location_of(const description::Sensor& sensor) {
  return std::visit([](const auto& observed) { return observed.points.location; }, sensor.observed);
}

ObservedQuantity quantity_of(const description::Sensor& sensor) {
  return std::visit([](const auto& observed) { return observed.quantity; }, sensor.observed);
}

/// Refuses channels without any number, with one value throughout, as of a dead sensor, or of strains that no structure
/// survives: such a channel is in um/m.
void check_channels(const Record& record, const description::Case& given) {
  IssueList issues;
  const std::string part = " (" + std::to_string(record.samples()) + " samples from " + shortest(record.start) +
                           " s to " + shortest(record.end()) + " s)";
  for (Index j = 0; j < record.values.rows(); ++j) {
    const auto& [name, sensor] = given.sensors[static_cast<std::size_t>(j)];
    const std::string channel = "sensors." + name + ": channel '" + sensor.channel.value_or(name) + "' ";
    const Eigen::ArrayXd values = record.values.row(j).transpose().array();
    const auto finite = values.isFinite();
    const double infinity = std::numeric_limits<double>::infinity();
    const double lowest = finite.select(values, infinity).minCoeff();
    if (!finite.any())
      issues.add(location_of(sensor), channel + "has no number in the record" + part,
                 "there is no data to estimate from", "remove the sensor or choose another channel");
    else if (lowest == finite.select(values, -infinity).maxCoeff() && !sensor.accept_constant)
      issues.add(location_of(sensor),
                 channel + "has the value " + shortest(lowest) + " " +
                     record.channels[static_cast<std::size_t>(j)].unit + " throughout the record" + part,
                 "a dead sensor would make the filter believe that nothing moves",
                 "remove the sensor or use a part of the record in which it works; if the value is a real measurement, "
                 "set accept_constant: true");
    else if (const double span = finite.select(values, -infinity).maxCoeff() - lowest;
             quantity_of(sensor) == ObservedQuantity::strain && span > plausible::strain().high)
      issues.add(location_of(sensor), channel + "spans a strain of " + shortest(span) + " m/m" + part,
                 "no structure is strained so much: the channel is probably in um/m", "set unit: um/m");
  }
  issues.raise();
}

/// SI unit of the quantity of a rotation: rad, rad/s and rad/s^2 for motions, nothing for those of connectors.
std::string rotational_unit_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return "rad";
    case ObservedQuantity::velocity:
      return "rad/s";
    case ObservedQuantity::acceleration:
      return "rad/s^2";
    default:
      return "";
  }
}

/// The column and unit of a sensor.
WantedChannel wanted_channel(const description::Case& given, const std::string& name,
                             const description::Sensor& sensor) {
  const auto quantity = quantity_of(sensor);
  return {.column = sensor.channel.value_or(name),
          .owner = "sensors." + name,
          .unit = unit_of(quantity),
          .rotational_unit = rotational_unit_of(quantity),
          .unit_key = "sensors." + name + ".unit",
          .unit_given = sensor.unit.value.empty() ? given.record->unit : sensor.unit};
}

/// The file of a sensor's channel.
const std::filesystem::path& file_of(const description::Case& given, const description::Sensor& sensor) {
  return sensor.file ? sensor.file->value : given.record->file.value;
}

/// Rows of one file as they are, one a sensor. `spread`: see RecordFileOptions.
Record read_file(const description::Case& given, const std::filesystem::path& file,
                 const std::vector<WantedChannel>& wanted, std::vector<std::string>& notes, bool* spread) {
  const auto& asked = *given.record;
  return read_record_file(file, wanted,
                          {.sample_rate = asked.sample_rate,
                           .dataset = asked.group,
                           .missing = asked.skip_missing,
                           .spread = spread,
                           .notes = &notes});
}

/// A row of a record with its own time, and without the samples that it does not have where rows are `spread`.
MeasuredChannel channel_of(const Record& record, Index row, const std::string& name, bool spread) {
  MeasuredChannel channel{.name = name, .start = record.start, .interval = 1.0 / record.sample_rate};
  channel.values = record.values.row(row).transpose();
  if (!spread) return channel;
  std::vector<Index> present;
  for (Index k = 0; k < channel.values.size(); ++k)
    if (std::isfinite(channel.values[k])) present.push_back(k);
  channel.times.resize(std::ssize(present));
  for (Index i = 0; i < channel.times.size(); ++i) channel.times[i] = record.time(present[static_cast<std::size_t>(i)]);
  channel.values = channel.values(present).eval();
  return channel;
}

/// Rows of the case's files, one a sensor, on the time that all share. `sensors`: of the case, one per wanted channel.
Record read_channels(const description::Case& given, const std::vector<const description::Sensor*>& sensors,
                     const std::vector<WantedChannel>& wanted, std::vector<std::string>& notes, bool* spread) {
  std::map<std::filesystem::path, std::vector<std::size_t>> files;
  for (std::size_t j = 0; j < sensors.size(); ++j) files[file_of(given, *sensors[j])].push_back(j);
  if (files.size() < 2)
    return read_file(given, files.empty() ? given.record->file.value : files.begin()->first, wanted, notes, spread);
  MeasuredFile together{.format = "several files"};
  together.channels.resize(wanted.size());
  std::vector<WantedChannel> in_order;
  for (const auto& each : wanted) in_order.push_back({.column = each.owner, .owner = each.owner, .unit = each.unit});
  IssueList issues;
  for (const auto& [file, places] : files) try {
      std::vector<WantedChannel> of_file;
      for (const std::size_t j : places) of_file.push_back(wanted[j]);
      bool rates_differ = false;
      const Record part = read_file(given, file, of_file, notes, &rates_differ);
      for (std::size_t i = 0; i < places.size(); ++i)
        together.channels[places[i]] = channel_of(part, static_cast<Index>(i), wanted[places[i]].owner, rates_differ);
    } catch (const InvalidInput& error) {
      issues.add(error, sensors[places.front()]->file.value_or(given.record->file).location);
    }
  issues.raise();
  return select_record(together, in_order, {.missing = given.record->skip_missing, .spread = spread, .notes = &notes},
                       given.record->file.value);
}

/// Filters need the samples between those that a channel of a lower rate has.
void check_preparation(const description::Case& given) {
  const auto& asked = given.record->prepare;
  const bool filters = asked.high_pass > 0.0 || asked.low_pass > 0.0 || asked.sample_rate;
  const auto late = std::ranges::find_if(
      given.sensors, [](const auto& each) { return each.second.delay != 0.0 || each.second.drift != 0.0; });
  if (!filters && late == given.sensors.end()) return;
  throw InvalidInput(Issue{given.record->file.location,
                           filters ? "record.prepare filters or resamples channels with sampling rates of their own"
                                   : "sensors." + late->first + (late->second.delay != 0.0 ? ".delay" : ".drift") +
                                         " is given, but the channels have sampling rates of their own",
                           "there are no samples between those of the slower channels",
                           "leave it out, or export the channels at one rate"});
}

std::string in_ppm(double drift) { return shortest(std::round(drift * 1e12) / 1e6) + " ppm"; }

/// Puts signals in the place of what sensors recorded of them.
void calibrate_sensors(PreparedRecord& prepared, const description::Case& given) {
  for (std::size_t j = 0; j < given.sensors.size(); ++j) {
    const auto& [name, sensor] = given.sensors[j];
    const auto calibration = calibration_of(name, sensor);
    if (!calibration.changes_anything()) continue;
    calibrate(prepared.record, static_cast<Index>(j), calibration);
    prepared.preparation.push_back(
        name + ": gain " + shortest(calibration.gain) + ", offset " + shortest(calibration.offset) + " " +
        prepared.record.channels[j].unit + ", delay " + shortest(calibration.delay) + " s" +
        (calibration.drift != 0.0 ? ", drift " + in_ppm(calibration.drift) : "") + " taken out");
  }
}

/// The part of a free response that the case asks for.
FreeResponsePart part_of(const description::FreeResponse& asked, const description::Case& given) {
  FreeResponsePart part{.delay = asked.delay, .threshold = asked.threshold, .margin = asked.margin};
  for (const auto& [name, sensor] : given.sensors) {
    const bool displacement = std::holds_alternative<Observed<ObservedQuantity::displacement>>(sensor.observed);
    part.rest_deviation.push_back(displacement ? asked.rest_std : std::nullopt);
  }
  return part;
}

/// Takes a step of the preparation; what is wrong is what the keys ask for.
template <class Action>
void as_asked_by(const std::string& keys, const Action& action) try {
  action();
} catch (const InvalidInput& error) {
  IssueList issues;
  for (const auto& [place, what, why, fix] : error.issues()) issues.add(place, keys + ": " + what, why, fix);
  issues.raise();
}

PreparedRecord read_prepared(const description::Case& given) {
  const auto& asked = *given.record;
  std::vector<std::string> notes;
  std::vector<WantedChannel> wanted;
  std::vector<const description::Sensor*> sensors;
  for (const auto& [name, sensor] : given.sensors) {
    wanted.push_back(wanted_channel(given, name, sensor));
    sensors.push_back(&sensor);
  }
  bool spread = false;
  PreparedRecord prepared{read_channels(given, sensors, wanted, notes, &spread)};
  prepared.preparation = std::move(notes);
  Record& record = prepared.record;
  prepared.began = record.start;
  for (std::size_t j = 0; j < given.sensors.size(); ++j) record.channels[j].name = given.sensors[j].first;
  if (spread) check_preparation(given);
  if (!spread) check_finite(record, asked);
  if (asked.repair_splice) repair_splice(prepared);
  calibrate_sensors(prepared, given);
  as_asked_by("record.prepare", [&] { prepare_channels(prepared, asked.prepare); });
  const double start = asked.start.value_or(record.start), end = asked.end.value_or(record.end());
  as_asked_by("record.start, record.end", [&] { record = cut(std::move(record), start, end); });
  check_channels(record, given);
  if (asked.free_response)
    as_asked_by("record.free_response", [&] { take_free_response(prepared, part_of(*asked.free_response, given)); });
  return prepared;
}

}  // namespace

namespace {

/// Problems without a place are those of the record's file.
template <class Reading>
auto of_record(const description::Case& given, const Reading& reading) {
  try {
    return reading();
  } catch (const InvalidInput& error) {
    IssueList issues;
    issues.add(error, given.record->file.location);
    throw InvalidInput(issues.issues());
  }
}

}  // namespace

ChannelCalibration calibration_of(const std::string& name, const description::Sensor& sensor) {
  if (sensor.gain == 0.0)
    throw InvalidInput(Issue{location_of(sensor), "sensors." + name + ".gain is 0",
                             "such a channel holds nothing of its signal", "write its gain, or leave it out for 1"});
  return {.gain = sensor.gain,
          .offset = sensor.offset ? checked_number(*sensor.offset, unit_of(quantity_of(sensor))) : 0.0,
          .delay = sensor.delay,
          .drift = sensor.drift};
}

PreparedRecord read_measured_record(const description::Case& given) {
  return of_record(given, [&] { return read_prepared(given); });
}

Record read_sensor_channel(const description::Case& given, const std::string& sensor) {
  const auto found = std::ranges::find(given.sensors, sensor, &std::pair<std::string, description::Sensor>::first);
  std::vector<std::string> notes;
  return of_record(given, [&] {
    return read_channels(given, {&found->second}, {wanted_channel(given, sensor, found->second)}, notes, nullptr);
  });
}

namespace {

/// Names the sensors that move fast for their sampling rate, beyond what their white noise shows there. A channel that
/// lacks samples is left out: its rate is a lower one, or its gaps would count.
void tell_fast_channels(PreparedRecord& prepared) {
  constexpr double told = 0.05;  // of the variance
  const Record& record = prepared.record;
  for (std::size_t j = 0; j < record.channels.size(); ++j) {
    const Eigen::VectorXd samples = record.values.row(static_cast<Index>(j)).transpose();
    if (!samples.allFinite() || !is_fast(samples)) continue;
    const double variance = (samples.array() - samples.mean()).square().mean();
    const double noise = 0.5 * record.channels[j].noise * record.channels[j].noise;
    const double share = share_above_quarter(samples) - noise / variance;
    if (share > told)
      prepared.preparation.push_back(record.channels[j].name + ": without its noise, " +
                                     fast_content(share, record.sample_rate) +
                                     "; a higher rate would show more of its motion");
  }
}

}  // namespace

void check_noise(const Study& study, const Record& record, const std::string& channel) {
  IssueList issues;
  for (std::size_t i = 0; i < record.channels.size(); ++i) {
    const auto& sensor = study.sensors[i];
    if (sensor.relative_noise && sensor.noise > 0.0 && record.channels[i].noise == 0.0)
      issues.add(sensor.location,
                 "sensors." + sensor.name + ".noise: the noise is " + shortest(100.0 * sensor.noise) +
                     " % of the channel's rms, but " + channel + " is 0 throughout",
                 "per cent of 0 gives no noise",
                 "give the noise in " + sensor.unit + ", or remove the sensor if nothing moves there");
  }
  issues.raise();
}

void set_noise(const Study& study, Record& record) {
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const double size = rms_of_present(record.values.row(static_cast<Eigen::Index>(i)).transpose());
    record.channels[i].unit = study.sensors[i].unit;
    record.channels[i].noise = study.sensors[i].deviation(size);
  }
  check_noise(study, record, "its channel");
}

void set_noise(Study& study) {
  set_noise(study, study.record->record);
  tell_fast_channels(*study.record);
}

}  // namespace kalfem
