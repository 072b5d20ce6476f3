// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/identified_connector.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/result_series.hpp"

namespace kalfem {
namespace {

/// Motions, unknowns and inputs, of the filter or the smoother.
void write_series(SeriesWriter& file, const std::string& group, const std::vector<PointQuantity>& points,
                  const std::vector<EstimatedInput>& inputs, const std::vector<UnknownParameter>& names,
                  const EstimatedSeries& unknowns) {
  file.write_points(group, points);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const std::string name = group + "/parameters/" + names[i].name;
    file.write(name, unknowns.mean.row(row).transpose(), names[i].unit);
    file.write(name + "_std", unknowns.deviation.row(row).transpose(), names[i].unit);
  }
  for (const auto& input : inputs) {
    const std::string name = group + "/inputs/" + input.input.name;
    file.write(name, input.mean, input.input.unit);
    file.write(name + "_std", input.deviation, input.input.unit);
    if (input.truth.size() > 0) file.write(name + "_true", input.truth, input.input.unit);
  }
}

/// At instants of their own.
void write_frequencies(SeriesWriter& file, const FrequencyCourse& course) {
  file.write("/estimate/frequencies/time", course.time, "s");
  for (Eigen::Index m = 0; m < course.frequency.rows(); ++m) {
    const std::string name = "/estimate/frequencies/mode_" + std::to_string(m + 1);
    file.write(name, course.frequency.row(m).transpose(), "Hz");
    file.write(name + "_std", course.deviation.row(m).transpose(), "Hz");
  }
}

/// The noise that was in force at each sample.
void write_noise(SeriesWriter& file, const NoiseCourse& course, const Record& measurements) {
  for (std::size_t i = 0; course.sensors_adapt && i < measurements.channels.size(); ++i) {
    const auto& channel = measurements.channels[i];
    file.write("/estimate/noise/" + channel.name, course.sensors.row(static_cast<Eigen::Index>(i)).transpose(),
               channel.unit);
  }
  if (course.process_factor.size() > 0)
    file.write("/estimate/noise/process", course.density * course.process_factor.cwiseSqrt(), "m/s^2/sqrt(Hz)");
}

/// The identified law of the main connector, over its rate or its deformation.
void write_law(SeriesWriter& file, const EstimationOutcome& outcome) {
  const auto law = law_curve(outcome);
  if (!law) return;
  const std::string group = "/law/" + law->connector + "/";
  file.write_column(group + (law->over_rate ? "rate" : "deformation"), law->abscissa, law->over_rate ? "m/s" : "m");
  file.write_column(group + "force", law->force, "N");
  if (law->deviation.size() > 0) file.write_column(group + "force_std", law->deviation, "N");
}

}  // namespace

void write_estimate(SeriesWriter& file, const EstimationOutcome& outcome) {
  const auto& names = outcome.augmented_model->options().unknowns;
  write_series(file, "/estimate", outcome.points, outcome.inputs, names, outcome.result.unknowns);
  if (outcome.frequencies) write_frequencies(file, *outcome.frequencies);
  if (outcome.result.noise) write_noise(file, *outcome.result.noise, outcome.measurements);
  if (outcome.smoothed)
    write_series(file, "/smoothed", outcome.smoothed_points, outcome.smoothed_inputs, names,
                 outcome.smoothed->unknowns);
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const auto& channel = outcome.measurements.channels[i];
    file.write("/innovation/value/" + channel.name, outcome.result.innovation.row(row).transpose(), channel.unit);
    file.write("/innovation/deviation/" + channel.name, outcome.result.innovation_deviation.row(row).transpose(),
               channel.unit);
    if (outcome.open_loop)
      file.write("/open_loop/" + channel.name, outcome.open_loop_sensors.row(row).transpose(), channel.unit);
  }
  file.write("/innovation/nis", outcome.result.nis, "-");
  if (outcome.has_samples()) write_law(file, outcome);
}

}  // namespace kalfem
