// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/judge_estimation.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/diagnosis/fixed_number_reasons.hpp"
#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/identification/parameter_drift.hpp"
#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/identification/unknown_information.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double hardly_seen = 0.7;     ///< of an unknown input's standard deviation without sensors
constexpr double drifting = 3.0;        ///< growth of a random walk's standard deviation over the record
constexpr double poor_open_loop = 0.9;  ///< NRMSE: hardly better than no motion at all
constexpr double few_outliers = 1e-3;   ///< of a channel's samples
constexpr Index fewest_values = 50;     ///< degrees of freedom of the tests behind a verdict

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

/// The robust deviation along time alone: what frequency bands contradict each other by must not excuse an estimate
/// that its nature forbids. Not a number where there is none.
double deviation_along_time(const RecordEstimate& estimate, Index i) {
  const auto& widening = estimate.robust.widening_by_bands;
  const auto& constants = estimate.result.unknowns_history.unknowns;
  const auto place = std::ranges::find(constants, i) - constants.begin();
  return estimate.robust_deviation[i] / (place < widening.size() ? widening[place] : 1.0);
}

/// The factor by which the filter is too sure of an unknown; 0 where it agrees with the record's information.
double too_sure(const RecordEstimate& estimate, Index i) {
  if (!estimate.information) return 0.0;
  const auto& [unknowns, covariance, step, widening] = *estimate.information;
  const auto place = std::ranges::find(unknowns, i) - unknowns.begin();
  return place < std::ssize(unknowns) ? widening[place] : 0.0;
}

/// One unknown beside its prior. Distances are those of the filter's state, in which the prior is normal.
EstimatedUnknown estimated_unknown(const RecordEstimate& estimate, Index i) {
  const auto& unknown = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
  const Index last = estimate.result.state.mean.cols() - 1, row = estimate.augmented_model->layout().unknown() + i;
  const double start = unknown.transform.to_state(unknown.initial);
  const double prior = unknown.deviation / unknown.transform.slope(start);
  const double deviation = estimate.result.unknowns.deviation(i, last), robust = estimate.robust_deviation[i];
  const double along_time = deviation_along_time(estimate, i);
  const double factor = too_sure(estimate, i);
  const Limits allowed = natural_limits(unknown, estimate.augmented_model->system());
  return {.name = unknown.name,
          .unit = unknown.unit,
          .initial = unknown.initial,
          .estimate = estimate.result.unknowns.mean(i, last),
          .moved = std::abs(estimate.result.state.mean(row, last) - start) / prior,
          .shrinkage = std::max(1.0, factor) * estimate.result.state.deviation(row, last) / prior,
          .deviation = std::isfinite(along_time) ? std::max(along_time, deviation) : deviation,
          .widening = std::isfinite(robust) && deviation > 0.0 ? robust / deviation : 1.0,
          .too_sure = factor > 0.0,
          .drifts = unknown.random_walk > 0.0,
          .least = allowed.least,
          .greatest = allowed.greatest,
          .lower_bound = unknown.transform.kind == TransformKind::logit ? unknown.transform.lower : -infinity,
          .upper_bound = unknown.transform.kind == TransformKind::logit ? unknown.transform.upper : infinity};
}

/// Of the unknowns among each other after the last sample; where the filter is too sure of one, constant unknowns by
/// the record's information, in no relation to those that walk.
MatrixXd covariance_of_unknowns(const RecordEstimate& estimate) {
  const auto& layout = estimate.augmented_model->layout();
  MatrixXd covariance =
      estimate.result.final_covariance.block(layout.unknown(), layout.unknown(), layout.unknowns, layout.unknowns);
  if (!estimate.information || !estimate.information->any_too_sure()) return covariance;
  const auto& unknowns = estimate.information->unknowns;
  for (const Index i : unknowns) covariance.row(i).setZero();
  for (const Index i : unknowns) covariance.col(i).setZero();
  covariance(unknowns, unknowns) = estimate.information->covariance;
  return covariance;
}

MatrixXd correlation_of_unknowns(const RecordEstimate& estimate) {
  const MatrixXd covariance = covariance_of_unknowns(estimate);
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

std::vector<Reason> reasons_of_unknowns(const RecordEstimate& estimate) {
  return unknown_reasons(estimated_unknowns(estimate), correlation_of_unknowns(estimate), estimate.consistency.mean_nis,
                         estimate.consistency.expected_nis);
}

/// A bias above half a deviation matters: below it 95 % intervals still hold the truth in 92 % of all records.
constexpr double large_bias = 0.5;

std::vector<Reason> reasons_of_substeps(const RecordEstimate& estimate) {
  const auto& choice = estimate.substeps;
  const Index largest = choice.largest();
  if (largest < 0 || choice.bias[largest] <= large_bias) return {};
  const double bias = choice.bias[largest];
  const std::string& name = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(largest)].name;
  const bool to_come = estimate.second_thoughts == SecondThoughts::pending;  // intervals hold the bias
  return {{"step_too_coarse", name,
           fmt::format("with {} substeps per sample{}, the filter's model biases '{}' by {:.2g} of its standard "
                       "deviations",
                       choice.substeps, to_come || choice.stopped ? "" : ", the most that are tried", name, bias),
           to_come          ? "more substeps are tried next"
           : choice.stopped ? "state second_thoughts: full, which tries more, or sample the record faster"
                            : "sample the record faster; the bias falls with the square of the sampling rate",
           to_come || choice.stopped ? VerdictState::suspicious : state_of(std::max(suspicious_widening, bias)), bias}};
}

/// Unknowns of the measurement that the record does not show, or that were not found.
std::vector<Reason> reasons_of_likelihood(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  if (!estimate.likelihood) return reasons;
  const auto& found = *estimate.likelihood;
  for (std::size_t i = 0; i < found.unknowns.size(); ++i) {
    const std::string& name = found.unknowns[i].name;
    const auto index = static_cast<Index>(i);
    if (!found.visible[i])
      reasons.push_back({"not_identified", name,
                         fmt::format("'{}' is not visible in the record: its standard deviation, {:.2g} {}, is that of "
                                     "its prior",
                                     name, found.deviation[index], found.unknowns[i].unit),
                         "hold it fixed, or use a record in which its sensor moves more", VerdictState::suspicious});
  }
  if (!found.converged)
    reasons.push_back({"likelihood_not_converged", found.unknowns.front().name,
                       "the search for the most likely gains, delays and noise did not converge",
                       "start it closer, or estimate fewer of them at once", VerdictState::suspicious});
  return reasons;
}

/// Outliers that the filter gave little weight, or none, bend no estimate while they are few.
bool is_allowed_for(const SensorEvent& event, const RecordEstimate& estimate) {
  const auto most = few_outliers * static_cast<double>(estimate.measurements.samples());
  return event.kind == EventKind::outliers && estimate.outliers != OutlierTreatment::keep &&
         static_cast<double>(event.count) <= std::max(1.0, most);
}

/// What was wrong with the sensors. It is left out of the estimates already, so it is a suspicion at most.
std::vector<Reason> reasons_of_events(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  for (const auto& event : estimate.events) {
    if (!event.is_fault() || is_allowed_for(event, estimate)) continue;
    const bool outliers = event.kind == EventKind::outliers;
    reasons.push_back({.code = outliers ? "outliers" : "sensor_" + to_string(event.kind),
                       .subject = event.channel,
                       .text = event.text,
                       .remedy = outliers ? "look at the record there" : "check the sensor, its cable and its range"});
  }
  return reasons;
}

const std::string& unit_of(const RecordEstimate& estimate, const ParameterJump& change) {
  return estimate.augmented_model->options().unknowns[static_cast<std::size_t>(change.unknown)].unit;
}

/// A constant unknown that did not stay constant: the cause of what else contradicts itself, and as grave as that.
std::vector<Reason> reasons_of_change(const RecordEstimate& estimate, VerdictState others) {
  std::vector<Reason> reasons;
  for (const auto& event : estimate.events) {
    if (!event.is_change()) continue;
    const bool drifts = event.kind == EventKind::drift;
    const std::string remedy =
        drifts ? fmt::format("estimate it as a random walk: state random_walk: {:.2g} (in {}/sqrt(s)) for '{}'",
                             random_walk_of(event, *estimate.jump), unit_of(estimate, *estimate.jump), event.channel)
               : "estimate the record in two parts, or give the unknown a random_walk";
    reasons.push_back({drifts ? "parameter_drift" : "parameter_jump", event.channel, event.text, remedy,
                       std::max(VerdictState::suspicious, others), infinity});
  }
  return reasons;
}

/// A test of few values passes nearly any model.
std::vector<Reason> reasons_of_length(const RecordEstimate& estimate) {
  const auto& measured = estimate.result.measured;
  const Index values = measured.tail(measured.size() - estimate.settled).sum();
  if (values >= fewest_values) return {};
  const std::string after =
      estimate.settled > 0 ? fmt::format(" after the first {:.3g} s", estimate.judged_from()) : "";
  return {{"record_too_short", "",
           fmt::format("the verdict rests on {} measured values{}: too few to tell a right model from a wrong one",
                       values, after),
           "record longer or sample faster; a shorter `settle` leaves more", VerdictState::suspicious, 1.0}};
}

/// The trial with up to three times as much or as little process noise in which an unknown moves furthest, if that is
/// out of its 95 % interval and more than the trial's own deviation allows: of an estimate with the best noise and
/// another one, the difference has the difference of their variances (Hausman 1978, Econometrica 46, 1251-1271). Of an
/// unknown that walks, means along the record are compared.
const ProcessNoiseTrial* furthest_out(const RecordEstimate& estimate, const ProcessNoiseTrial& stated, Index i) {
  constexpr double near = 3.1, band = 1.96;
  const auto& unknown = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
  const StatedInterval interval = stated_interval(estimate, i);
  const ProcessNoiseTrial* furthest = nullptr;
  double largest = 0.0;
  for (const auto& trial : estimate.process_noise) {
    const double value = trial.estimates[i], moved = std::abs(value - stated.estimates[i]);
    const bool out = unknown.random_walk > 0.0 ? moved > band * stated.deviations[i]
                                               : value < interval.lower || value > interval.upper;
    if (trial.factor > near || trial.factor < 1.0 / near || !out || moved <= largest) continue;
    if (moved <= band * trial.deviations[i]) continue;
    furthest = &trial;
    largest = moved;
  }
  return furthest;
}

std::vector<Reason> reasons_of_process_noise(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  const auto stated = std::ranges::find(estimate.process_noise, 1.0, &ProcessNoiseTrial::factor);
  if (stated == estimate.process_noise.end()) return reasons;
  for (Index i = 0; i < stated->estimates.size(); ++i) {
    const auto* trial = furthest_out(estimate, *stated, i);
    if (!trial) continue;
    const auto& unknown = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
    const double gain = trial->log_likelihood - stated->log_likelihood;
    reasons.push_back(
        {"process_noise_decides", unknown.name,
         fmt::format("'{}' depends on the process noise: with {:.2g} times as much it is {:.4g} {} in the place of "
                     "{:.4g}, outside its 95 % interval, and the record is {} likely by {:.3g} (logarithm)",
                     unknown.name, trial->factor, trial->estimates[i], unknown.unit, stated->estimates[i],
                     gain > 0.0 ? "more" : "less", std::abs(gain)),
         "make process_noise an unknown, or look for what the model leaves out", VerdictState::suspicious,
         std::abs(trial->estimates[i] - stated->estimates[i]) / stated->deviations[i]});
  }
  return reasons;
}

constexpr double far_from_stated = 3.0;  ///< factor between deviations: stated noise is rarely better known
constexpr double significant = 4.0;      ///< standard deviations

Reason far_noise(const std::string& subject, const std::string& noise, const std::string& unit, double stated,
                 double found, const std::string& of_model) {
  const double factor = std::max(found / stated, stated / found);
  return {"noise_adapted_far",
          subject,
          stated > 0.0 ? fmt::format("{} adapted from {:.2g} to {:.2g} {}: {:.2g} times {}", noise, stated, found, unit,
                                     factor, found > stated ? "as much" : "less")
                       : fmt::format("{} is stated as 0 and adapted to {:.2g} {}", noise, found, unit),
          found > stated ? fmt::format("{}; where the model is right, state {:.2g} {}", of_model, found, unit)
                         : fmt::format("state {:.2g} {}", found, unit),
          VerdictState::suspicious,
          stated > 0.0 ? factor : far_from_stated};
}

/// Noise that had to move far to explain the record: it may have swallowed what the model misses.
std::vector<Reason> reasons_of_adapted_noise(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  if (!estimate.result.noise) return reasons;
  const auto& noise = *estimate.result.noise;
  const Index last = noise.sensors.cols() - 1;
  const auto is_far = [](double log_ratio, double deviation) {
    return std::abs(log_ratio) > std::log(far_from_stated) + significant * deviation;
  };
  for (std::size_t i = 0; noise.sensors_adapt && i < estimate.measurements.channels.size(); ++i) {
    const auto& channel = estimate.measurements.channels[i];
    const auto row = static_cast<Index>(i);
    const double found = noise.sensors(row, last);
    if (is_far(std::log(found / channel.noise), noise.sensor_uncertainty[row]))
      reasons.push_back(far_noise(channel.name, "the noise of '" + channel.name + "'", channel.unit, channel.noise,
                                  found,
                                  "check the sensor and the model near it: what the model misses counts as noise"));
  }
  if (noise.process_factor.size() == 0 || !(noise.density > 0.0)) return reasons;
  const double found = noise.density_at(last), stated = noise.density_is_stated ? noise.density : 0.0;
  const double log_factor = std::log(noise.process_factor[last]);
  // Where none is stated, a density of factor one is hardly visible.
  const bool far = noise.density_is_stated ? is_far(0.5 * log_factor, 0.5 * noise.process_uncertainty)
                                           : log_factor > significant * noise.process_uncertainty;
  if (far)
    reasons.push_back(far_noise("process noise", "the process noise", "m/s^2/sqrt(Hz)", stated, found,
                                "look for what the model leaves out: a force, a mode or another law"));
  return reasons;
}

std::vector<Reason> reasons_of_open_loop(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  if (!estimate.open_loop_failure.empty())
    reasons.push_back({"open_loop_failed", "", estimate.open_loop_failure,
                       "the estimates do not describe the structure by themselves: check the priors and the laws"});
  for (std::size_t j = 0; j < estimate.open_loop_nrmse.size(); ++j) {
    const std::string& sensor = estimate.measurements.channels[j].name;
    const double error = estimate.open_loop_nrmse[j];
    if (error > poor_open_loop)
      reasons.push_back(
          {"open_loop_error", sensor,
           fmt::format("simulated with the estimates alone, '{}' has an error of {:.2g} of the record's size", sensor,
                       error),
           "the filter follows the record, but its model does not: look for a wrong law or a missing part",
           VerdictState::suspicious, error});
  }
  return reasons;
}

/// An input whose band stays nearly as wide as its process, and one whose band grows, are hardly in the record.
std::vector<Reason> reasons_of_inputs(const RecordEstimate& estimate) {
  std::vector<Reason> reasons;
  for (const auto& input : estimate.inputs) {
    const std::string& name = input.input.name;
    const double left = input.shrinkage(estimate.settled);
    const Index samples = input.deviation.size(), settled = std::min(estimate.settled, samples - 1);
    const double growth = input.deviation[samples - 1] / input.deviation[settled];
    if (!input.input.is_random_walk() && left > hardly_seen)
      reasons.push_back({"input_not_identified", name,
                         fmt::format("the sensors hardly show the unknown excitation '{}': its standard deviation is "
                                     "{:.0f} % of that which its process has without any sensor",
                                     name, 100.0 * left),
                         "put a sensor nearer to where it acts, or one of displacement if it is slow"});
    if (input.input.is_random_walk() && growth > drifting)
      reasons.push_back({"input_drifts", name,
                         fmt::format("the unknown excitation '{}' drifts: its standard deviation grew {:.3g} times "
                                     "from {:.4g} s to the end",
                                     name, growth, estimate.measurements.time(settled)),
                         "give std and correlation_time instead of random_walk, or measure a displacement"});
  }
  return reasons;
}

/// The reason `band_too_narrow` where a sensor, predicted from all others, contradicts its band: those of quantities
/// that no sensor measures do not hold either. Process noise that mends it is the remedy.
std::vector<Reason> held_out_reasons(const RecordEstimate& estimate) {
  const auto* study = estimate.held_out_sensors.get();
  const auto* worst = study ? study->worst() : nullptr;
  if (!worst) return {};
  std::string remedy =
      "look for what the model leaves out; until then rely on no band of a quantity that no sensor measures";
  if (study->proposes())
    remedy = fmt::format(
        "look for what the model leaves out, or let process noise stand for it, with which the bands hold: "
        "process_noise: {{acceleration: {:.2g} m/s^2/sqrt(Hz)}}, adaptive_noise: {{process: true}} (log-likelihood "
        "{:+.3g})",
        study->adapted->density, study->adapted->gain);
  return {{.code = "band_too_narrow",
           .subject = worst->name,
           .text = fmt::format("predicted from the other sensors, '{}' contradicts its band, which holds {:.3g} % of "
                               "its samples and about {:.2g} % of its motion: 95 % bands of quantities that no sensor "
                               "measures are too narrow",
                               worst->name, 100.0 * worst->inside, 100.0 * worst->motion_inside),
           .remedy = std::move(remedy),
           .weight = std::max(worst->followed, worst->in_band)}};
}

}  // namespace

std::vector<EstimatedUnknown> estimated_unknowns(const RecordEstimate& estimate) {
  std::vector<EstimatedUnknown> unknowns;
  for (Index i = 0; i < estimate.augmented_model->layout().unknowns; ++i)
    unknowns.push_back(estimated_unknown(estimate, i));
  return unknowns;
}

Verdict verdict_of(const RecordEstimate& estimate) {
  Verdict verdict;
  if (const auto& failure = estimate.result.failure) {
    verdict.add(
        {"failed", failure->subject, estimate.failure(), failure->remedy, VerdictState::unusable, unusable_widening});
    return verdict;
  }
  verdict.add(reasons_of_events(estimate));
  verdict.add(innovation_reasons(innovations_of(estimate)));
  verdict.add(reasons_of_substeps(estimate));
  verdict.add(reasons_of_unknowns(estimate));
  verdict.add(reasons_of_likelihood(estimate));
  verdict.add(reasons_of_inputs(estimate));
  verdict.add(reasons_of_process_noise(estimate));
  verdict.add(reasons_of_adapted_noise(estimate));
  verdict.add(reasons_of_open_loop(estimate));
  verdict.add(reasons_of_length(estimate));
  verdict.add(fixed_number_reasons(estimate));
  verdict.add(held_out_reasons(estimate));
  verdict.add(reasons_of_change(estimate, verdict.state()));
  return verdict;
}

}  // namespace kalfem
