#include "kalfem/pipeline/run_verdict.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

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

void judge_updating(const UpdatingOutcome& outcome, Verdict& verdict) {
  if (!outcome.converged)
    verdict.add({"not_converged", "update", "the updating did not converge: " + outcome.termination,
                 "start nearer, refine fewer parameters, or allow more iterations"});
  for (const auto& comparison : outcome.comparisons)
    if (state_of(comparison.rms_final) != VerdictState::consistent)
      verdict.add({"residual_large", comparison.name,
                   fmt::format("after the updating, comparison '{}' still differs by {:.3g} of its stated standard "
                               "deviations",
                               comparison.name, comparison.rms_final),
                   "the model cannot follow the measurement, or its stated deviations are too small",
                   VerdictState::suspicious, comparison.rms_final});
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
Verdict verdict_of(const StudyResults& results) {
  Verdict verdict;
  if (!results.complete()) {
    Reason failed{"failed", "", results.failure, "", VerdictState::unusable, unusable_widening};
    if (results.estimation && results.estimation->result.failure) {
      failed.subject = results.estimation->result.failure->subject;
      failed.remedy = results.estimation->result.failure->remedy;
    }
    verdict.add(failed);
  } else {
    if (results.updating) judge_updating(*results.updating, verdict);
    if (results.estimation) judge_estimation(*results.estimation, verdict);
  }
  if (results.validation) judge_validation(*results.validation, verdict);
  if (results.estimation && results.estimation->diagnosis)
    verdict.add(reasons_of(*results.estimation->diagnosis, verdict.state()));
  return verdict;
}

}  // namespace kalfem
