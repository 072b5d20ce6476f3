// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "calls.hpp"
#include "kalfem/base/units.hpp"
#include "options.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

using Eigen::Index;

namespace {

constexpr double deviations_per_second = 100.0;  ///< of states and outputs, as the command computes them

py::dict parameters_summary(const EstimateResult& result, const EstimateOptions& options) {
  py::dict all;
  for (const auto& parameter : result.parameters) {
    const auto& [name, unit, mean, std, std_robust, interval, mean_history, std_history, std_considered] = parameter;
    const auto& prior = std::ranges::find(options.unknowns, name, &UnknownDescription::name)->prior;
    py::dict entry;
    entry["estimate"] = number(mean);
    entry["std"] = number(std);
    entry["std_robust"] = number(std_robust);
    entry["std_considered"] = number(std_considered);
    entry["interval_95"] = py::make_tuple(number(interval.lower), number(interval.upper));
    entry["unit"] = unit;
    if (prior.initial) entry["initial"] = *prior.initial;
    if (prior.std > 0.0) entry["prior_std"] = prior.std;
    all[py::str(name)] = entry;
  }
  return all;
}

py::dict sensitivity_summary(const EstimateResult& result) {
  py::list numbers;
  for (const auto& each : result.fixed_numbers) {
    py::dict shift, entry;
    for (std::size_t j = 0; j < each.shift.size(); ++j)
      shift[py::str(result.parameters[j].name)] = number(each.shift[j] / each.scale);
    entry["name"] = each.name;
    entry["group"] = each.group;
    entry["unit"] = each.unit;
    entry["value"] = number(each.value);
    entry["known_to"] = each.known_to > 0.0 ? number(each.known_to * each.scale) : py::none();
    entry["stands_at_change"] = number(each.stands_at * each.scale);
    entry["asked_change"] = number(each.asked * each.scale);
    entry["asked_change_std"] = number(each.asked_std * each.scale);
    entry["log_likelihood_gain"] = number(each.log_likelihood_gain);
    entry["shift"] = shift;
    numbers.append(entry);
  }
  py::dict summary;
  summary["numbers"] = numbers;
  return summary;
}

py::dict freed_summary(const EstimateResult& result, FreeNumbers how) {
  py::list tried, moved;
  for (const auto& each : result.number_trials) {
    py::dict entry;
    entry["name"] = each.name;
    entry["unit"] = each.unit;
    entry["held"] = number(each.held);
    entry["prior_std"] = number(each.prior_std);
    entry["value"] = number(each.value);
    entry["std"] = number(each.std);
    entry["predicted_gain"] = number(each.predicted_gain);
    entry["kept"] = each.kept;
    tried.append(entry);
  }
  for (const auto& each : result.moved_by_freed) {
    py::dict entry;
    entry["parameter"] = each.parameter;
    entry["unit"] = each.unit;
    entry["before"] = number(each.before);
    entry["after"] = number(each.after);
    entry["deviations"] = number(each.deviations);
    moved.append(entry);
  }
  py::dict summary;
  summary["how"] = to_string(how);
  summary["tried"] = tried;
  summary["moved"] = moved;
  return summary;
}

py::dict held_out_sensors_summary(const std::vector<HeldOutSensor>& sensors) {
  py::dict all;
  for (const auto& each : sensors) {
    py::dict entry;
    entry["unit"] = each.unit;
    entry["samples"] = each.samples;
    entry["inside"] = each.inside;
    entry["motion_std"] = each.motion_deviation;
    entry["noise_std"] = each.noise;
    entry["followed_errors"] = each.followed;
    entry["errors_in_band"] = each.in_band;
    entry["motion_inside"] = each.motion_inside;
    entry["holds"] = each.holds();
    all[py::str(each.name)] = entry;
  }
  return all;
}

py::dict held_out_summary(const EstimateResult& result) {
  py::dict summary;
  summary["sensors"] = held_out_sensors_summary(result.held_out_sensors);
  if (const auto& adapted = result.adapted_process) {
    py::dict trial;
    trial["acceleration"] = adapted->density;
    trial["log_likelihood_gain"] = adapted->gain;
    trial["mends"] = adapted->mends;
    trial["sensors"] = held_out_sensors_summary(adapted->sensors);
    summary["adapted_process_noise"] = trial;
  }
  return summary;
}

py::dict estimation_summary(const EstimateResult& result) {
  py::dict nis, estimation;
  nis["mean"] = number(result.mean_nis(static_cast<double>(result.settled) / result.sample_rate));
  nis["expected"] = result.innovation.rows();
  estimation["filter"] = result.filter;
  estimation["start"] = result.start;
  estimation["substeps"] = result.substeps;
  estimation["log_likelihood"] = number(result.log_likelihood);
  estimation["nis"] = nis;
  return estimation;
}

py::dict summary_of(const EstimateResult& result, const EstimateOptions& options) {
  py::dict summary;
  const auto reasons = result.verdict.reasons();
  std::string message;
  if (!result.usable() && !reasons.empty()) message = sentence_of(reasons.front());
  summary["title"] = "estimate";
  summary["status"] = result.usable() ? "ok" : "unusable";
  summary["message"] = message;
  summary["verdict"] = python::summary_of(result.verdict);
  summary["parameters"] = parameters_summary(result, options);
  summary["estimation"] = estimation_summary(result);
  if (!result.fixed_numbers.empty()) summary["sensitivity"] = sensitivity_summary(result);
  if (!result.held_out_sensors.empty()) summary["held_out"] = held_out_summary(result);
  if (!result.number_trials.empty()) summary["freed"] = freed_summary(result, options.free);
  return summary;
}

/// "body.2.displacement" as "/estimate/body.2/displacement".
std::string path_of(const std::string& state) {
  const auto dot = state.rfind('.');
  return "estimate/" + (dot == std::string::npos ? state : state.substr(0, dot) + "/" + state.substr(dot + 1));
}

py::dict datasets_of(EstimateResult& result, const Record& record, const std::vector<SensorDescription>& sensors) {
  Datasets data;
  const double rate = record.sample_rate;
  const auto add = [&](const std::string& path, auto values, const std::string& unit) {
    data.add(path, Eigen::VectorXd(std::move(values)), unit, rate);
  };
  add("time", times_of(record), "s");
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const std::string unit = unit_of(sensors[i].output.quantity);
    add("measurements/" + sensors[i].name, record.values.row(row).transpose(), unit);
    add("innovation/value/" + sensors[i].name, result.innovation.row(row).transpose(), unit);
    add("innovation/deviation/" + sensors[i].name, result.innovation_deviation.row(row).transpose(), unit);
  }
  for (auto& [name, unit, mean, std] : result.states) {
    add(path_of(name), std::move(mean), unit);
    add(path_of(name) + "_std", std::move(std), unit);
  }
  for (auto& [name, unit, mean, std] : result.outputs) {
    add("estimate/" + name, std::move(mean), unit);
    add("estimate/" + name + "_std", std::move(std), unit);
  }
  for (auto& parameter : result.parameters) {
    add("estimate/parameters/" + parameter.name, std::move(parameter.mean_history), parameter.unit);
    add("estimate/parameters/" + parameter.name + "_std", std::move(parameter.std_history), parameter.unit);
  }
  add("innovation/nis", std::move(result.nis), "-");
  for (auto& score : result.scores) add("innovation/scores/" + score.name, std::move(score.value), "");
  py::dict all = data.take();
  if (result.innovation_covariance.size() > 0)
    all["innovation/covariance"] =
        py::make_tuple(covariances_of(result.innovation_covariance, std::ssize(sensors)), py::dict());
  return all;
}

/// Times in milliseconds look like seconds. They are too far apart for any mode of the structure.
void refuse_milliseconds(const Structure& structure, const TimeGrid& grid) {
  constexpr double slow = 20.0;  // [Hz]: of milliseconds, a rate of 20 kHz
  if (grid.sample_rate > slow) return;
  double lowest = 0.0;
  try {
    for (const double frequency : modes(structure, 10).frequencies)
      if (frequency > 0.0 && (lowest == 0.0 || frequency < lowest)) lowest = frequency;
  } catch (const InvalidInput&) {
    return;  // whoever estimates says what is wrong with the structure
  }
  if (lowest > 0.5 * grid.sample_rate)
    throw InvalidInput("t: its steps are " + shortest(1.0 / grid.sample_rate) +
                           " s, but the structure's lowest natural frequency is " +
                           shortest(std::round(10.0 * lowest) / 10.0) + " Hz",
                       "so slow a record shows no vibration: t looks like milliseconds", "give t in seconds, t / 1000");
}

/// The arguments of an estimation in the library's types.
struct Question {
  Structure structure;
  Record record;
  EstimateOptions options;
};

Question question_of(const Structure& structure, const py::object& t, const py::object& y, const py::dict& inputs,
                     const py::dict& arguments) {
  EstimateOptions options = options_of(structure, arguments);
  std::vector<std::string> names;
  for (const auto& sensor : options.sensors) names.push_back(sensor.name);
  const TimeGrid grid = grid_of(t);
  refuse_milliseconds(structure, grid);
  const Record record = record_of(grid, y, names);
  set_relative_noise(arguments["sensors"], record, options.sensors);
  options.deviation_stride = std::max(1, static_cast<int>(std::lround(grid.sample_rate / deviations_per_second)));
  return {driven(structure, inputs, grid.start, grid.sample_rate, grid.samples), record, options};
}

py::tuple estimate_record(const Structure& structure, const py::object& t, const py::object& y, const py::dict& inputs,
                          const py::dict& arguments, const py::object& progress) {
  auto [moved, record, options] = question_of(structure, t, y, inputs, arguments);
  warn_of_slow_laws(structure, record.samples());
  auto result =
      long_call(structure, progress, [&, &moved = moved, &record = record, &options = options](const Progress& report) {
        options.progress = report;
        return estimate(moved, record, options);
      });
  const py::dict summary = summary_of(result, options);
  return py::make_tuple(summary, datasets_of(result, record, options.sensors));
}

const char* word_for(ObservedQuantity quantity) {
  if (quantity == ObservedQuantity::displacement) return "displacement";
  return quantity == ObservedQuantity::acceleration ? "acceleration" : "strain";
}

py::tuple predict_substructure(const Structure& structure, const py::object& t, const py::object& y,
                               const std::string& substructure, int steps, const py::dict& inputs,
                               const py::dict& arguments, const py::object& progress) {
  auto question = question_of(structure, t, y, inputs, arguments);
  PredictOptions options{.estimate = question.options, .substructure = substructure, .steps = steps};
  auto result = long_call(structure, progress, [&](const Progress& report) {
    options.estimate.progress = report;
    return predict(question.structure, question.record, options);
  });
  py::dict summary = summary_of(result.estimate, question.options);
  summary["title"] = "predict";
  if (!result.failure.empty()) {
    summary["status"] = "unusable";
    summary["message"] = result.failure;
  }
  py::dict all = datasets_of(result.estimate, question.record, question.options.sensors);
  Datasets predicted;
  for (auto& [place, unit, quantity, values] : result.predicted)
    predicted.add("prediction/" + place + "/" + word_for(quantity), std::move(values), unit,
                  question.record.sample_rate);
  all.attr("update")(predicted.take());
  return py::make_tuple(summary, all);
}

}  // namespace

py::dict summary_of(const Verdict& verdict) {
  py::list reasons;
  for (const auto& reason : verdict.reasons()) {
    py::dict entry;
    entry["code"] = reason.code;
    entry["subject"] = reason.subject;
    entry["text"] = reason.text;
    entry["remedy"] = reason.remedy;
    reasons.append(entry);
  }
  py::dict summary;
  summary["state"] = to_string(verdict.state());
  summary["reasons"] = reasons;
  return summary;
}

py::array_t<double> covariances_of(const Eigen::MatrixXd& triangles, Index sensors) {
  py::array_t<double> all({triangles.cols(), sensors, sensors});
  auto entries = all.mutable_unchecked<3>();
  for (Index k = 0; k < triangles.cols(); ++k)
    for (Index i = 0, row = 0; i < sensors; ++i)
      for (Index j = 0; j <= i; ++j, ++row) entries(k, i, j) = entries(k, j, i) = triangles(row, k);
  return all;
}

Eigen::VectorXd times_of(const Record& record) {
  const Index samples = record.samples();
  return Eigen::VectorXd::LinSpaced(samples, record.start,
                                    record.start + static_cast<double>(samples - 1) / record.sample_rate);
}

void bind_estimate(py::module_& module) {
  module.def(
      "time_grid",
      [](const py::object& t) {
        const auto [start, sample_rate, samples] = grid_of(t);
        return py::make_tuple(start, sample_rate, samples);
      },
      py::arg("t"), "Start [s], sampling rate [Hz] and number of even times.");
  module.def("estimate", &estimate_record, py::arg("structure"), py::arg("t"), py::arg("y"), py::arg("inputs"),
             py::arg("arguments"), py::arg("progress") = py::none(),
             "Summary and datasets of an estimation: see kalfem.estimate.");
  module.def("predict", &predict_substructure, py::arg("structure"), py::arg("t"), py::arg("y"),
             py::arg("substructure"), py::arg("steps"), py::arg("inputs"), py::arg("arguments"),
             py::arg("progress") = py::none(), "Those of an estimation with a prediction: see kalfem.predict.");
}

}  // namespace kalfem::python
