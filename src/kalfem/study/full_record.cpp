#include "kalfem/study/full_record.hpp"

#include "kalfem/base/units.hpp"

namespace kalfem {

void check_noise(const Study& study, const std::vector<double>& noise, const std::string& channel) {
  IssueList issues;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const auto& sensor = study.sensors[i];
    if (sensor.relative_noise && sensor.noise > 0.0 && noise[i] == 0.0)
      issues.add(sensor.location,
                 "sensors." + sensor.name + ".noise: the noise is " + shortest(100.0 * sensor.noise) +
                     " % of the channel's rms, but " + channel + " is 0 throughout",
                 "per cent of 0 gives no noise",
                 "give the noise in " + sensor.unit + ", or remove the sensor if nothing moves there");
  }
  issues.raise();
}

FullRecord measured_record(const Study& study) {
  FullRecord record{study.record->series, {}, study.record->used};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto channel = static_cast<Eigen::Index>(i);
    record.noise.push_back(study.sensors[i].deviation(rms_of_present(record.series.values.col(channel))));
    record.series.channels[i].unit = study.sensors[i].unit;
  }
  check_noise(study, record.noise, "its channel");
  return record;
}

}  // namespace kalfem
