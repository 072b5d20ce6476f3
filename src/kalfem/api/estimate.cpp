// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/estimate.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/sensor_record.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/diagnosis/look_for_cause.hpp"
#include "kalfem/identification/fixed_number_study.hpp"
#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/stated_interval.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

OutputDescription at(ObservedQuantity quantity, const std::string& place) { return {"", quantity, {{place, 1.0}}}; }

void add_found_by_likelihood(const LikelihoodEstimate& found, std::vector<ParameterEstimate>& parameters) {
  for (std::size_t i = 0; i < found.unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto interval = found.interval(row);
    parameters.push_back({.name = found.unknowns[i].name,
                          .unit = found.unknowns[i].unit,
                          .mean = found.values[row],
                          .std = found.deviation[row],
                          .std_robust = found.robust_deviation[row],
                          .interval_95 = {interval.lower, interval.upper}});
  }
}

std::vector<ParameterEstimate> parameters_of(const RecordEstimate& estimated) {
  std::vector<ParameterEstimate> parameters;
  const auto& unknowns = estimated.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const VectorXd mean = estimated.result.unknowns.mean.row(row).transpose();
    const VectorXd std = estimated.result.unknowns.deviation.row(row).transpose();
    const auto interval = stated_interval(estimated, row);
    parameters.push_back({.name = unknowns[i].name,
                          .unit = unknowns[i].unit,
                          .mean = mean[mean.size() - 1],
                          .std = std[std.size() - 1],
                          .std_robust = estimated.robust_deviation[row],
                          .interval_95 = {interval.lower, interval.upper},
                          .mean_history = mean,
                          .std_history = std,
                          .std_considered = considered_deviation(estimated, row)});
  }
  if (estimated.likelihood) add_found_by_likelihood(*estimated.likelihood, parameters);
  return parameters;
}

std::vector<FixedNumberEffect> effects_of(const FixedNumberStudy& study) {
  std::vector<FixedNumberEffect> effects;
  for (Index i = 0; i < study.size(); ++i) {
    const FixedNumber& number = study.numbers[static_cast<std::size_t>(i)];
    const auto column = [i](const Eigen::MatrixXd& all) {
      return std::vector<double>(all.col(i).begin(), all.col(i).end());
    };
    effects.push_back({.name = number.name,
                       .unit = number.unit,
                       .group = group_of(number.kind),
                       .value = number.value,
                       .scale = number.scale,
                       .known_to = number.deviation,
                       .stands_at = study.stands_at[i],
                       .asked = study.asked[i],
                       .asked_std = study.asked_deviation[i],
                       .log_likelihood_gain = study.gain[i],
                       .shift = column(study.shift),
                       .considered = column(study.considered)});
  }
  return effects;
}

void set_freed(const FreedNumbers& freed, EstimateResult& estimate) {
  for (const auto& tried : freed.tried)
    estimate.number_trials.push_back({.name = tried.name,
                                      .unit = tried.number.unit,
                                      .held = tried.number.value,
                                      .prior_std = tried.prior,
                                      .value = tried.value,
                                      .std = tried.deviation,
                                      .predicted_gain = tried.predicted,
                                      .kept = tried.kept});
  for (const auto& [name, unit, before, after, deviations] : freed.moved)
    estimate.moved_by_freed.push_back({name, unit, before, after, deviations});
}

std::vector<NormalisedInnovations> innovations_by_sensor(const RecordEstimate& estimated) {
  std::vector<NormalisedInnovations> sensors;
  for (const auto& found : sensor_consistency(innovations_of(estimated)))
    sensors.push_back({.sensor = estimated.measurements.channels[sensors.size()].name,
                       .rms = found.ratio,
                       .largest_part = found.largest_part,
                       .correlation = found.lag_one.value,
                       .beyond_half_gate = found.beyond_half_gate});
  return sensors;
}

/// Splits the monitored quantities: motion of points and internal states of connectors go to `states`, requested
/// outputs to `outputs`.
void set_quantities(const FilterProblem& made, const EstimateOptions& options, const RecordEstimate& estimated,
                    EstimateResult& estimate) {
  const auto& result = estimated.result;
  const std::size_t motions = made.monitored.size() - options.outputs.size();
  for (std::size_t i = 0; i < made.monitored.size(); ++i) {
    const auto row = static_cast<Index>(i);
    auto& list = i < motions ? estimate.states : estimate.outputs;
    list.push_back({made.monitored[i].name, unit_of(made.monitored[i]), result.monitored.mean.row(row).transpose(),
                    result.monitored.deviation.row(row).transpose()});
  }
  Index row = estimated.augmented_model->layout().connector_state();
  for (const auto& connector : made.setup.model->system().connectors)
    for (const auto& state : connector.law->states()) {
      estimate.states.push_back({connector.name + "." + state.name, state.unit, result.state.mean.row(row).transpose(),
                                 result.state.deviation.row(row).transpose()});
      ++row;
    }
}

template <class T>
const T& named(const std::vector<T>& all, const std::string& name, const char* what) {
  const auto found = std::ranges::find(all, name, &T::name);
  if (found != all.end()) return *found;
  std::vector<std::string> known;
  for (const auto& each : all) known.push_back(each.name);
  throw InvalidInput(std::string("the result has no ") + what + " '" + name + "'" + did_you_mean(name, known), "", "");
}

}  // namespace

OutputDescription displacement(const std::string& point) { return at(ObservedQuantity::displacement, point); }
OutputDescription velocity(const std::string& point) { return at(ObservedQuantity::velocity, point); }
OutputDescription acceleration(const std::string& point) { return at(ObservedQuantity::acceleration, point); }
OutputDescription strain(const std::string& gauge) { return at(ObservedQuantity::strain, gauge); }
OutputDescription connector_force(const std::string& connector) {
  return at(ObservedQuantity::connector_force, connector);
}
OutputDescription connector_deformation(const std::string& connector) {
  return at(ObservedQuantity::connector_deformation, connector);
}
OutputDescription connector_rate(const std::string& connector) {
  return at(ObservedQuantity::connector_rate, connector);
}

double EstimateResult::mean_nis(double settle) const {
  const Index from = std::min(nis.size(), static_cast<Index>(std::llround(settle * sample_rate)));
  const auto counted = nis.tail(nis.size() - from).array();
  const auto measured = counted.isFinite();
  return measured.select(counted, 0.0).sum() / static_cast<double>(std::max<Index>(1, measured.count()));
}

const ParameterEstimate& EstimateResult::parameter(const std::string& name) const {
  return named(parameters, name, "parameter");
}
const EstimatedQuantity& EstimateResult::state(const std::string& name) const { return named(states, name, "state"); }
const EstimatedQuantity& EstimateResult::output(const std::string& name) const {
  return named(outputs, name, "output");
}

EstimateResult estimate(const Structure& structure, const Record& record, const EstimateOptions& options) {
  require_signals(structure.description());
  const Record measured = record_of_sensors(record, options.sensors);
  FilterProblem made = make_filter_problem(structure, record.sample_rate, options);
  auto estimated = estimate_record_thoroughly(
      made.problem, made.setup, measured,
      {.monitored = made.monitored, .deviation_stride = options.deviation_stride, .progress = options.progress});
  const auto& filtered = estimated.result;
  if (estimated.freed && estimated.freed->taken) made.problem = estimated.freed->problem;
  EstimateResult estimate;
  estimate.parameters = parameters_of(estimated);
  set_quantities(made, options, estimated, estimate);
  estimate.innovation = filtered.innovation;
  estimate.innovation_deviation = filtered.innovation_deviation;
  estimate.innovation_covariance = filtered.innovation_covariance;
  estimate.used = used_samples(filtered);
  estimate.nis = filtered.nis;
  estimate.scores = scores_of_unknowns(estimated);
  estimate.log_likelihood = filtered.log_likelihood;
  estimate.filter = to_string(estimated.filter) + ": " + estimated.filter_reason;
  estimate.substeps = estimated.substeps.substeps;
  estimate.substep_bias = estimated.substeps.bias;
  estimate.start = explain(estimated.start);
  estimate.sample_rate = record.sample_rate;
  estimate.settled = estimated.settled;
  if (const auto& failure = filtered.failure)
    estimate.failure = FilterStop{record.start + failure->time, failure->reason + "; " + failure->remedy};
  estimate.sensors = innovations_by_sensor(estimated);
  estimate.diagnosis = look_for_cause(*made.problem, made.problem->structure->parts, measured, estimated);
  estimate.verdict = verdict_of(estimated);
  estimate.left_out = estimated.left_out;
  if (estimated.fixed_numbers) estimate.fixed_numbers = effects_of(*estimated.fixed_numbers);
  if (estimated.freed) set_freed(*estimated.freed, estimate);
  if (estimated.held_out_sensors) {
    estimate.held_out_sensors = estimated.held_out_sensors->sensors;
    estimate.adapted_process = estimated.held_out_sensors->adapted;
  }
  if (estimate.diagnosis) estimate.verdict.add(reasons_of(*estimate.diagnosis, estimate.verdict.state()));
  return estimate;
}

}  // namespace kalfem
