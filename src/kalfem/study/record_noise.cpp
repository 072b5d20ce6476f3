#include "kalfem/study/record_noise.hpp"

#include "kalfem/base/units.hpp"

namespace kalfem {

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

void set_noise(Study& study) {
  Record& record = study.record->record;
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const double size = rms_of_present(record.values.row(static_cast<Eigen::Index>(i)).transpose());
    record.channels[i].unit = study.sensors[i].unit;
    record.channels[i].noise = study.sensors[i].deviation(size);
  }
  check_noise(study, record, "its channel");
}

}  // namespace kalfem
