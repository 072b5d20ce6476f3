#include "kalfem/pipeline/run_verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/verdict/updating_checks.hpp"
#include "kalfem/verdict/validation_checks.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double poor_open_loop = 0.9;  ///< NRMSE: hardly better than no motion at all

struct Limits {
  double least = -infinity, greatest = infinity;
};

Limits limits_of(Range range) {
  switch (range) {
    case Range::nonnegative:
    case Range::positive:
      return {0.0, infinity};
    case Range::fraction:
      return {0.0, 1.0};
    case Range::at_least_one:
      return {1.0, infinity};
    case Range::any:
      break;
  }
  return {};
}

/// Values that nature allows: those of the law's parameter, and none below zero of what a linear part is made of.
Limits natural_limits(const UnknownParameter& unknown, const LocallyNonlinearSystem& system) {
  for (const char* positive : {".mass", ".stiffness", ".damping", ".youngs_modulus", ".density", ".thickness"})
    if (unknown.name.ends_with(positive)) return {0.0, infinity};
  Limits limits;
  for (const auto& target : unknown.targets) {
    const auto& law = *system.connectors[static_cast<std::size_t>(target.connector)].law;
    const Limits own = limits_of(law.parameters()[static_cast<std::size_t>(target.parameter)].range);
    limits = {std::max(limits.least, own.least), std::min(limits.greatest, own.greatest)};
  }
  return limits;
}

/// One unknown beside its prior. Distances are those of the filter's state, in which the prior is normal.
EstimatedUnknown estimated_unknown(const EstimationOutcome& outcome, Index i) {
  const auto& unknown = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
  const Index last = outcome.result.state.mean.cols() - 1, row = outcome.augmented_model->layout().unknown() + i;
  const double start = unknown.transform.to_state(unknown.initial);
  const double prior = unknown.deviation / unknown.transform.slope(start);
  const double deviation = outcome.result.unknowns.deviation(i, last), robust = outcome.robust_deviation[i];
  const Limits allowed = natural_limits(unknown, outcome.augmented_model->system());
  return {.name = unknown.name,
          .unit = unknown.unit,
          .initial = unknown.initial,
          .estimate = outcome.result.unknowns.mean(i, last),
          .moved = std::abs(outcome.result.state.mean(row, last) - start) / prior,
          .shrinkage = outcome.result.state.deviation(row, last) / prior,
          .deviation = std::isfinite(robust) ? std::max(robust, deviation) : deviation,
          .widening = std::isfinite(robust) && deviation > 0.0 ? robust / deviation : 1.0,
          .drifts = unknown.random_walk > 0.0,
          .least = allowed.least,
          .greatest = allowed.greatest,
          .lower_bound = unknown.transform.kind == TransformKind::logit ? unknown.transform.lower : -infinity,
          .upper_bound = unknown.transform.kind == TransformKind::logit ? unknown.transform.upper : infinity};
}

/// Of the unknowns among each other after the last sample.
MatrixXd correlation_of_unknowns(const EstimationOutcome& outcome) {
  const auto& layout = outcome.augmented_model->layout();
  const MatrixXd covariance =
      outcome.result.final_covariance.block(layout.unknown(), layout.unknown(), layout.unknowns, layout.unknowns);
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

/// A bias above half a deviation matters: below it 95 % intervals still hold the truth in 92 % of all records.
constexpr double large_bias = 0.5;

void judge_substeps(const EstimationOutcome& outcome, Verdict& verdict) {
  const auto& choice = outcome.substeps;
  const Index largest = choice.largest();
  if (largest < 0 || choice.bias[largest] <= large_bias) return;
  const double bias = choice.bias[largest];
  const std::string& name = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(largest)].name;
  verdict.add({"step_too_coarse", name,
               fmt::format("with {} substeps per sample, the most that are tried, the filter's model biases '{}' by "
                           "{:.2g} of its standard deviations",
                           choice.substeps, name, bias),
               "sample the record faster; the bias falls with the square of the sampling rate",
               state_of(std::max(suspicious_widening, bias)), bias});
}

void judge_estimation(const EstimationOutcome& outcome, Verdict& verdict) {
  verdict.add(innovation_reasons(innovations_of(outcome)));
  judge_substeps(outcome, verdict);
  std::vector<EstimatedUnknown> unknowns;
  for (Index i = 0; i < outcome.augmented_model->layout().unknowns; ++i)
    unknowns.push_back(estimated_unknown(outcome, i));
  verdict.add(unknown_reasons(unknowns, correlation_of_unknowns(outcome), outcome.consistency.mean_nis,
                              outcome.consistency.expected_nis));
  if (!outcome.open_loop_failure.empty())
    verdict.add({"open_loop_failed", "", outcome.open_loop_failure,
                 "the estimates do not describe the structure by themselves: check the priors and the laws"});
  for (std::size_t j = 0; j < outcome.open_loop_nrmse.size(); ++j)
    if (outcome.open_loop_nrmse[j] > poor_open_loop)
      verdict.add({"open_loop_error", outcome.measurements.channels[j].name,
                   fmt::format("simulated with the estimates alone, '{}' has an error of {:.2g} of the record's size",
                               outcome.measurements.channels[j].name, outcome.open_loop_nrmse[j]),
                   "the filter follows the record, but its model does not: look for a wrong law or a missing part",
                   VerdictState::suspicious, outcome.open_loop_nrmse[j]});
}

/// Values less the parameters' share of them, which is taken as the same for every comparison.
double degrees_of_freedom(const ComparisonResult& comparison, const UpdatingOutcome& outcome) {
  double values = 0.0;
  for (const auto& each : outcome.comparisons) values += static_cast<double>(each.size);
  return static_cast<double>(comparison.size) * outcome.statistics.degrees_of_freedom / std::max(1.0, values);
}

ComparedMeasurement compared_measurement(const ComparisonResult& comparison, const UpdatingOutcome& outcome) {
  constexpr double least_mac = 0.5;
  ComparedMeasurement compared{.name = comparison.name,
                               .rms = comparison.rms_final,
                               .degrees_of_freedom = degrees_of_freedom(comparison, outcome),
                               .predicted = !comparison.derivatives.empty()};
  for (const auto& mode : comparison.modes_final)
    if (!mode.model_mode || mode.mac < least_mac)
      compared.poor_pairs.push_back(fmt::format("{:.4g} Hz (MAC {:.2f})", mode.measured_frequency, mode.mac));
  return compared;
}

bool is_positive_by_nature(const std::string& name) {
  constexpr std::array endings = {".stiffness", ".mass", ".thickness", ".youngs_modulus", ".density"};
  return std::ranges::any_of(endings, [&](const char* ending) { return name.ends_with(ending); });
}

UpdatedValue updated_value(const UpdatingParameter& parameter, Index i, const UpdatingOutcome& outcome) {
  const double stated = outcome.statistics.deviations[i], robust = outcome.robust.deviations[i];
  UpdatedValue value{.name = parameter.name,
                     .unit = parameter.unit,
                     .initial = parameter.initial,
                     .value = outcome.values[i],
                     .at_bound = outcome.statistics.at_bound[static_cast<std::size_t>(i)],
                     .positive_by_nature = is_positive_by_nature(parameter.name)};
  if (std::isfinite(parameter.deviation)) value.prior_deviation = parameter.deviation;
  if (std::isfinite(robust) && stated > 0.0 && std::isfinite(stated)) value.widening = robust / stated;
  value.widening_freedom = outcome.robust.degrees_of_freedom;
  return value;
}

/// Names of what the data do not determine: combinations and pairs, and single parameters that are in none of them.
void add_identifiability(const std::vector<UpdatingParameter>& parameters, const ParameterStatistics& statistics,
                         UpdatingRecord& record) {
  const auto name = [&](Index i) { return parameters[static_cast<std::size_t>(i)].name; };
  std::vector<bool> named(parameters.size(), false);
  for (const auto& combination : statistics.unidentifiable) {
    auto& names = record.not_told_apart.emplace_back();
    for (const Index i : combination.parameters) {
      names.push_back(name(i));
      named[static_cast<std::size_t>(i)] = true;
    }
  }
  for (const auto& pair : statistics.correlated) record.not_told_apart.push_back({name(pair.first), name(pair.second)});
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (!named[i] && (statistics.seen[i] == Seen::poorly || statistics.seen[i] == Seen::not_at_all))
      record.not_identified.push_back(parameters[i].name);
}

void judge_updating(const std::vector<UpdatingParameter>& parameters, const UpdatingOutcome& outcome,
                    Verdict& verdict) {
  UpdatingRecord record{.converged = outcome.converged, .termination = outcome.termination};
  for (const auto& comparison : outcome.comparisons)
    record.comparisons.push_back(compared_measurement(comparison, outcome));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    record.parameters.push_back(updated_value(parameters[i], static_cast<Index>(i), outcome));
  add_identifiability(parameters, outcome.statistics, record);
  verdict.add(updating_reasons(record));
}

void judge_validation(const ValidationOutcome& outcome, Verdict& verdict) {
  const auto& [held_back, own] = outcome;
  if (!held_back.failure.empty())
    verdict.add({"validation_failed", "", "the validation gave no comparison: " + held_back.failure,
                 "the estimates do not describe the structure by themselves: check the priors, the laws and the inputs",
                 VerdictState::suspicious, unusable_widening});
  std::vector<ValidatedSensor> sensors;
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j) {
    sensors.push_back(
        {.name = held_back.measured.channels[j].name, .error = held_back.nrmse[j], .noise = held_back.noise[j]});
    if (own.nrmse.empty()) continue;
    sensors.back().own_error = own.nrmse[j];
    sensors.back().own_noise = own.noise[j];
  }
  verdict.add(validation_reasons(sensors));
}

}  // namespace

InnovationRecord innovations_of(const EstimationOutcome& outcome) {
  InnovationRecord record{.noise = outcome.measurements.noise(),
                          .innovation = outcome.result.innovation,
                          .deviation = outcome.result.innovation_deviation,
                          .sample_rate = outcome.measurements.sample_rate,
                          .start = outcome.measurements.start,
                          .first = outcome.settled,
                          .nis = outcome.result.nis,
                          .measured = outcome.result.measured};
  for (const auto& channel : outcome.measurements.channels) {
    record.sensors.push_back(channel.name);
    record.units.push_back(channel.unit);
  }
  return record;
}

Verdict verdict_of(const EstimationOutcome& outcome) {
  Verdict verdict;
  judge_estimation(outcome, verdict);
  return verdict;
}

// Reasons come from each step that ran. A step that failed is the reason, and what it left is not judged: it would only
// say again that there is nothing.
Verdict verdict_of(const Study& study, const StudyResults& results) {
  Verdict verdict;
  if (!results.complete()) {
    Reason failed{"failed", "", results.failure, "", VerdictState::unusable, unusable_widening};
    if (results.estimation && results.estimation->result.failure) {
      failed.subject = results.estimation->result.failure->subject;
      failed.remedy = results.estimation->result.failure->remedy;
    }
    verdict.add(failed);
  } else {
    if (results.updating) judge_updating(study.updating->parameters, *results.updating, verdict);
    if (results.estimation) judge_estimation(*results.estimation, verdict);
  }
  if (results.validation) judge_validation(*results.validation, verdict);
  if (results.estimation && results.estimation->diagnosis)
    verdict.add(reasons_of(*results.estimation->diagnosis, verdict.state()));
  return verdict;
}

}  // namespace kalfem
