// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/alignment.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {
namespace {

constexpr double least_correlation = 0.5;

}  // namespace

CommonDelay delay_behind_record(const description::Case& given, const description::FileSignal& input) {
  const auto& [channel, sensor] = *input.align;
  const auto refuse = [&, &sensor = sensor](const std::string& what, const std::string& why, const std::string& fix) {
    throw InvalidInput(sensor.issue(what, why, fix));
  };
  if (!given.record)
    refuse("align: the case reads no record", "the clock of this file is compared with that of the record",
           "remove align");
  const auto found =
      std::ranges::find(given.sensors, sensor.value, &std::pair<std::string, description::Sensor>::first);
  if (found == given.sensors.end())
    refuse("align: there is no sensor '" + sensor.value + "'", "", "name a sensor of the case");
  const auto quantity = std::visit([](const auto& observed) { return observed.quantity; }, found->second.observed);
  const Record late =
      read_record_file(input.file, {{.column = channel.value, .owner = "align.channel", .unit = unit_of(quantity)}},
                       {.sample_rate = input.sample_rate, .missing = true});
  const CommonDelay delay = common_delay(read_sensor_channel(given, sensor.value), late);
  if (!(std::abs(delay.correlation) >= least_correlation))
    refuse("align: '" + channel.value + "' and sensor '" + sensor.value + "' correlate by " +
               shortest(std::round(delay.correlation * 1e3) / 1e3) + " at most, whatever their delay",
           "both must have measured the same", "name a channel that the two files share, or give the delay");
  return delay;
}

}  // namespace kalfem
