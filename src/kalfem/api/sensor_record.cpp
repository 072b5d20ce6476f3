// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/sensor_record.hpp"

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;

void require_channels(const Record& record, const std::vector<SensorDescription>& sensors) {
  std::vector<std::string> known;
  for (const auto& channel : record.channels) known.push_back(channel.name);
  IssueList issues;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (record.find(sensors[i].name) < 0)
      issues.add({},
                 "sensors[" + std::to_string(i) + "] '" + sensors[i].name +
                     "': the record has no channel of that name" + did_you_mean(sensors[i].name, known),
                 "", "name the sensor as the channel");
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (const Index row = record.find(sensors[i].name); row >= 0 && row < record.values.rows() &&
                                                        record.samples() > 0 &&
                                                        !record.values.row(row).array().isFinite().any())
      issues.add({}, "sensors[" + std::to_string(i) + "] '" + sensors[i].name + "': its channel has no number",
                 "there is no data to estimate from", "remove the sensor or choose another channel");
  if (static_cast<Index>(known.size()) != record.values.rows())
    issues.add({},
               "record: it has " + std::to_string(record.values.rows()) + " rows and " + std::to_string(known.size()) +
                   " channels",
               "every row of the values needs a name", "");
  if (record.samples() < 1) issues.add({}, "record: it has no samples", "there is nothing to estimate from", "");
  issues.raise();
}

Record record_of_sensors(const Record& record, const std::vector<SensorDescription>& sensors) {
  require_channels(record, sensors);
  std::vector<std::string> names;
  for (const auto& sensor : sensors) names.push_back(sensor.name);
  Record selected = select_channels(record, names);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    selected.channels[i] = {sensors[i].name, unit_of(sensors[i].output), sensors[i].noise};
  return selected;
}

}  // namespace kalfem
