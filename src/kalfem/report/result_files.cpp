// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/result_set.hpp"

#include "kalfem/base/version.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/write.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {
namespace {

struct QuantityName {
  const char* name;
  const char* unit;
};

QuantityName name_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return {"displacement", "m"};
    case ObservedQuantity::velocity:
      return {"velocity", "m/s"};
    case ObservedQuantity::acceleration:
      return {"acceleration", "m/s^2"};
    case ObservedQuantity::connector_deformation:
      return {"deformation", "m"};
    case ObservedQuantity::connector_rate:
      return {"rate", "m/s"};
    case ObservedQuantity::connector_force:
      return {"force", "N"};
    case ObservedQuantity::strain:
      return {"strain", "m/m"};
  }
  return {"", ""};
}

/// Hands over the series of a run, most of which have its sampling rate; those without values are left out.
class SeriesWriter {
public:
  SeriesWriter(double sample_rate, const SeriesVisitor& visit) : sample_rate_(sample_rate), visit_(visit) {}

  void write(const std::string& name, const Eigen::VectorXd& values, const std::string& unit) {
    if (values.size() > 0) visit_({name, values, unit, sample_rate_});
  }

  void write_points(const std::string& group, const std::vector<PointQuantity>& points) {
    for (const auto& point : points) {
      const auto [quantity, unit] = name_of(point.quantity);
      const std::string name = group + "/" + point.point + "/" + quantity;
      write(name, point.mean, unit);
      write(name + "_std", point.deviation, unit);
    }
  }

  /// A column without a time: one value per iteration of the updating, or per line of a response.
  void write_column(const std::string& name, const Eigen::VectorXd& values, const std::string& unit) {
    if (values.size() > 0) visit_({name, values, unit});
  }

  /// Values of Markov chains, one chain after the other.
  void write_chains(const std::string& name, const Eigen::VectorXd& values, const std::string& unit,
                    Eigen::Index chains) {
    if (values.size() > 0) visit_({name, values, unit, {}, chains});
  }

private:
  double sample_rate_;
  const SeriesVisitor& visit_;
};

void write_truth(SeriesWriter& file, const Study& study, const SimulationOutcome& outcome) {
  file.write_points("/truth", outcome.points);
  const auto& inputs = outcome.reference.simulation.trajectory.inputs;
  for (Eigen::Index i = 0; i < study.model->system().input_count(); ++i) {
    const auto& input = study.model->system().inputs[static_cast<std::size_t>(i)];
    file.write("/inputs/" + input.name, inputs.row(i).transpose(), input.unit);
  }
}

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
}

/// Both columns over the time of the validation part, which has its own sampling rate.
void write_validation(SeriesWriter& file, const OpenLoopComparison& comparison) {
  const auto& measured = comparison.measured;
  Eigen::VectorXd time(measured.samples());
  for (Eigen::Index k = 0; k < time.size(); ++k) time[k] = measured.time(k);
  file.write_column("/validation/time", time, "s");
  for (std::size_t j = 0; j < measured.channels.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const std::string name = "/validation/" + measured.channels[j].name;
    file.write_column(name + "/measured", measured.values.row(row).transpose(), measured.channels[j].unit);
    if (comparison.simulated.size() > 0)
      file.write_column(name + "/simulated", comparison.simulated.row(row).transpose(), measured.channels[j].unit);
  }
}

/// Every iteration: the residual, the parameters tried, the parameters accepted last. Then the compared responses.
void write_updating(SeriesWriter& file, const Study& study, const UpdatingOutcome& outcome) {
  const auto iterations = static_cast<Eigen::Index>(outcome.trace.size());
  const auto column = [&](const auto& value) {
    Eigen::VectorXd values(iterations);
    for (Eigen::Index k = 0; k < iterations; ++k) values[k] = value(outcome.trace[static_cast<std::size_t>(k)]);
    return values;
  };
  file.write_column("/updating/residual", column([](const auto& step) { return step.residual; }), "-");
  file.write_column("/updating/accepted", column([](const auto& step) { return step.accepted ? 1.0 : 0.0; }), "-");
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto index = static_cast<Eigen::Index>(i);
    const std::string name = "/updating/parameters/" + parameter.name;
    file.write_column(name, column([&](const auto& step) { return step.parameters[index]; }), parameter.unit);
    file.write_column(name + "_tried", column([&](const auto& step) { return step.tried[index]; }), parameter.unit);
  }
  for (const auto& comparison : outcome.comparisons)
    for (std::size_t i = 0; i < comparison.responses.size(); ++i) {
      const auto& curve = comparison.responses[i];
      const std::string group = "/updating/responses/" + comparison.name + "/" + std::to_string(i + 1);
      file.write_column(group + "/frequency", curve.lines, "Hz");
      for (const auto& [name, values] :
           {std::pair{"measured", &curve.measured}, {"before", &curve.before}, {"after", &curve.after}}) {
        file.write_column(group + "/" + name, values->cwiseAbs(), curve.unit);
        if (!curve.magnitudes_only) file.write_column(group + "/" + name + "_phase", values->cwiseArg(), "rad");
      }
      if (curve.coherence.size() > 0) file.write_column(group + "/coherence", curve.coherence, "-");
    }
}

/// Equally weighted draws and their densities, in the groups and under the names of ArviZ's InferenceData.
void write_posterior(SeriesWriter& file, const InferenceOutcome& outcome) {
  const bool weighted = outcome.samples.weights.size() > 0;
  const SampleSet draws = weighted ? resample(outcome.samples, outcome.samples.values.cols()) : outcome.samples;
  for (std::size_t i = 0; i < draws.names.size(); ++i)
    file.write_chains("/posterior/" + draws.names[i], draws.values.row(static_cast<Eigen::Index>(i)).transpose(),
                      i < outcome.units.size() ? outcome.units[i] : "-", draws.chains);
  file.write_chains("/sample_stats/lp", draws.log_likelihood + draws.log_prior, "-", draws.chains);
  file.write_chains("/sample_stats/log_likelihood", draws.log_likelihood, "-", draws.chains);
}

/// Over the time of the record's part that was simulated.
void write_bands(SeriesWriter& file, const std::vector<PredictiveBand>& bands) {
  if (bands.empty()) return;
  const auto& first = bands.front();
  Eigen::VectorXd time(first.mean.size());
  for (Eigen::Index k = 0; k < time.size(); ++k) time[k] = first.start + static_cast<double>(k) / first.sample_rate;
  file.write_column("/predictive/time", time, "s");
  for (const auto& band : bands) {
    const std::string name = "/predictive/" + band.sensor;
    file.write_column(name + "/measured", band.measured, band.unit);
    file.write_column(name + "/lower", band.lower, band.unit);
    file.write_column(name + "/mean", band.mean, band.unit);
    file.write_column(name + "/upper", band.upper, band.unit);
  }
}

void write_inference(SeriesWriter& file, const InferenceOutcome& outcome) {
  if (outcome.samples.values.cols() > 0) write_posterior(file, outcome);
  write_bands(file, outcome.bands);
  for (const auto& profile : outcome.profiles) {
    file.write_column("/profile/" + profile.name + "/value", profile.values, profile.unit);
    file.write_column("/profile/" + profile.name + "/log_likelihood", profile.log_likelihood, "-");
  }
}

/// The record of a run, if it has one.
const Record* measured_of(const StudyResults& results) {
  if (results.estimation) return &results.estimation->measurements;
  return results.simulation ? &results.simulation->measurements : nullptr;
}

/// The time over which a series stands, if it has as many instants: its group's, or that of a group around it.
std::optional<std::string> time_of(const Hdf5File& file, const ResultSeries& series) {
  for (auto slash = series.path.rfind('/'); slash != std::string::npos; slash = series.path.rfind('/', slash - 1)) {
    const std::string time = series.path.substr(0, slash) + "/time";
    if (file.contains(time)) return file.shape(time)[0] == series.values.size() ? std::optional(time) : std::nullopt;
    if (slash == 0) break;
  }
  return std::nullopt;
}

/// Draws of Markov chains over the chains and draws of their group.
void write_draws(Hdf5File& file, const ResultSeries& series) {
  const std::string group = series.path.substr(0, series.path.rfind('/'));
  const std::vector<std::string> axes{group + "/chain", group + "/draw"};
  if (!file.contains(axes.front())) {
    file.write_axis(axes.front(), *series.chains);
    file.write_axis(axes.back(), series.values.size() / *series.chains);
  }
  file.write_rows(series.path, series.values, *series.chains);
  file.set_axes(series.path, axes);
}

/// Dimensions get the names that netCDF-4 asks for: time, chain and draw.
void write_dataset(Hdf5File& file, const ResultSeries& series) {
  if (series.chains) {
    write_draws(file, series);
    return;
  }
  const auto time = time_of(file, series);
  file.write(series.path, series.values);
  if (series.path.ends_with("/time"))
    file.make_axis(series.path);
  else if (time)
    file.set_axes(series.path, {*time});
}

/// H by input, output and quantity: magnitude and phase of each model.
void write_frequency_response(SeriesWriter& file, const FrequencyResponseOutcome& outcome) {
  file.write_column("/frequency_response/frequency", outcome.frequencies, "Hz");
  for (const auto& response : outcome.responses)
    for (const auto& [name, values] : {std::pair{"full", &response.full}, {"reduced", &response.reduced}}) {
      const std::string path =
          "/frequency_response/" + response.input + "/" + response.output + "/" + response.quantity + "/" + name;
      file.write_column(path, values->cwiseAbs(), response.unit);
      file.write_column(path + "_phase", values->cwiseArg(), "rad");
    }
}

}  // namespace

void visit_results(const Study& study, const StudyResults& results, const SeriesVisitor& visit) {
  SeriesWriter file(study.sample_rate(), visit);
  if (results.updating) write_updating(file, study, *results.updating);
  if (results.validation) write_validation(file, results.validation->held_back);
  if (results.inference) write_inference(file, *results.inference);
  if (results.frequency_response) write_frequency_response(file, *results.frequency_response);
  const Record* record = measured_of(results);
  if (!record) return;
  const Eigen::Index samples =
      results.simulation ? results.simulation->reference.simulation.trajectory.samples() : record->samples();
  file.write("/time",
             Eigen::VectorXd::LinSpaced(samples, record->start,
                                        record->start + static_cast<double>(samples - 1) / study.sample_rate()),
             "s");
  const Record& measurements = results.simulation ? results.simulation->measurements : *record;
  for (std::size_t i = 0; i < measurements.channels.size(); ++i)
    file.write("/measurements/" + measurements.channels[i].name,
               measurements.values.row(static_cast<Eigen::Index>(i)).transpose(), measurements.channels[i].unit);
  if (results.simulation) write_truth(file, study, *results.simulation);
  if (results.estimation) write_estimate(file, *results.estimation);
  if (results.prediction) file.write_points("/prediction", results.prediction->points);
}

void write_results(const std::string& path, const Study& study, const StudyResults& results, const std::string& run) {
  if (!measured_of(results) && !results.updating && !results.inference && !results.frequency_response) return;
  Hdf5File file = Hdf5File::create(path);
  file.set_attribute("/", "kalfem", version);
  file.set_attribute("/", "run", run);
  file.set_attribute("/", "sample_rate", study.sample_rate());
  visit_results(study, results, [&](const ResultSeries& series) {
    write_dataset(file, series);
    file.set_attribute(series.path, "unit", series.unit);
    if (series.sample_rate) file.set_attribute(series.path, "sample_rate", *series.sample_rate);
  });
  file.close();
}

namespace {

const char* ending(MatrixFormat format) {
  switch (format) {
    case MatrixFormat::dmig:
      return ".dmig";
    case MatrixFormat::op4:
      return ".op4";
    case MatrixFormat::hdf5:
      return ".h5";
    default:
      return ".mtx";
  }
}

}  // namespace

void write_superelements(const std::filesystem::path& folder, const Study& study) {
  for (const auto& elements : study.structure->finite_elements)
    for (const auto format : study.report.superelements)
      if (elements.reduced)
        write_superelement(folder / (elements.part->name + "_reduced" + ending(format)), elements.reduced->model,
                           format, elements.reduced->basis);
}

}  // namespace kalfem
