// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameter_jumps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/linalg/scaled_inverse.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of the largest T along a record: by chance above 16 in about 1 of 500 records (Andrews 1993, Table 1, continued).
constexpr double worth_a_run = 16.0;
constexpr double near_the_largest = 0.2;  ///< T of another unknown that is tried too
constexpr std::size_t most_tried = 4;     ///< unknowns, of which the best
constexpr std::size_t most_placed = 2;    ///< are placed
constexpr int most_moves = 4;             ///< by one step
constexpr double significant = 30.0;      ///< gain
constexpr double most_left = 0.5;         ///< of the excess of NIS, where the change explains it
constexpr double band = 1.96;             ///< standard deviations of a change
constexpr double trimmed = 0.02;          ///< of an unknown's information at either end
constexpr Index coarse_parts = 64;        ///< of the record: the step to which every unknown's change is placed

/// A change that the scores hint at.
struct Hint {
  Index unknown = 0;  ///< among the constants
  Index sample = 0;
  double statistic = 0.0;
};

/// The largest T of each constant unknown.
std::vector<Hint> hints_of(const UnknownsHistory& history, Index first) {
  const MatrixXd last = history.covariance_at(history.last()), prior = scaled_inverse(history.covariance_at(0));
  const VectorXd whole = (scaled_inverse(last) - prior).diagonal();
  const VectorXd estimate = history.mean.col(history.last()), start = prior * (history.mean.col(0) - estimate);
  std::vector<Hint> hints(history.unknowns.size());
  ScaledInverse inverse;
  MatrixXd gained;
  VectorXd score, variance;
  for (Index k = 1; k < history.last(); ++k) {
    const Index sample = k * history.stride;
    if (sample <= first) continue;
    const MatrixXd& information = inverse(history.covariance_at(k));
    gained = information - prior;
    score = information * (history.mean.col(k) - estimate) - start;
    variance = (gained - gained * last * gained).diagonal();
    for (std::size_t i = 0; i < hints.size(); ++i) {
      const auto row = static_cast<Index>(i);
      const double share = gained(row, row) / whole[row];
      if (!(share > trimmed && share < 1.0 - trimmed && variance[row] > 0.0)) continue;
      const double statistic = score[row] * score[row] / variance[row];
      if (statistic > hints[i].statistic) hints[i] = {row, sample, statistic};
    }
  }
  std::ranges::sort(hints, std::greater{}, &Hint::statistic);
  return hints;
}

/// A run with a change, and its log-likelihood.
struct Trial {
  Index unknown = 0, sample = 0;
  EstimationResult result;

  [[nodiscard]] double log_likelihood() const {
    return result.failure ? -std::numeric_limits<double>::infinity() : result.log_likelihood;
  }
};

class JumpSearch {
public:
  JumpSearch(const AugmentedModel& augmented_model, const FilterInput& input, EstimationOptions options, Index first,
             double steps, StepBudget& budget)
      : augmented_model_(augmented_model),
        input_(input),
        options_(std::move(options)),
        first_(first),
        steps_(steps),
        budget_(budget) {
    options_.passes = 1;  // a further pass would begin with the value after the change
    options_.keep_unknowns = options_.state_means = false;
    options_.monitored = {};
    options_.progress = {};
  }

  [[nodiscard]] bool stopped() const { return stopped_; }  ///< the budget allowed no further run

  EstimationResult without_change() {
    if (!takes_a_run()) return {};
    return estimate(augmented_model_, input_, options_);
  }

  Trial with_change(Index unknown, Index sample) {
    if (!takes_a_run()) return {unknown, sample, {}};
    const auto& of = augmented_model_.options().unknowns[static_cast<std::size_t>(unknown)];
    EstimationOptions options = options_;
    options.renewals = {{unknown, sample, of.deviation / of.transform.slope(of.transform.to_state(of.initial))}};
    return {unknown, sample, estimate(augmented_model_, input_, options)};
  }

  /// Moves the change to the largest likelihood by steps that are halved from `step` down to `finest`. A step is
  /// repeated a few times only: where the likelihood keeps rising, the change is nowhere near.
  Trial placed(Trial best, Index step, Index finest) {
    for (; step >= finest && !stopped_; step /= 2)
      for (int i = 0; i < most_moves && moves(best, step); ++i) {
      }
    return best;
  }

private:
  bool takes_a_run() {
    if (!stopped_) stopped_ = !budget_.take(steps_);
    return !stopped_;
  }

  bool moves(Trial& best, Index step) {
    for (const Index sample : {best.sample - step, best.sample + step}) {
      if (sample <= first_ || sample >= input_.measured.samples()) continue;
      Trial moved = with_change(best.unknown, sample);
      if (stopped_ || !(moved.log_likelihood() > best.log_likelihood())) continue;
      best = std::move(moved);
      return true;
    }
    return false;
  }

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  EstimationOptions options_;
  Index first_;
  double steps_;
  StepBudget& budget_;
  bool stopped_ = false;
};

/// How far the innovations of a run are from what they should be.
struct Contradiction {
  double widening = 1.0;  ///< of deviations, at least 1
  double excess = 0.0;    ///< mean of NIS / degrees of freedom - 1, at least 0
  bool any = false;
};

Contradiction contradiction_of(const FilterInput& input, const EstimationResult& result, Index first) {
  const InnovationRecord innovations = innovations_of(input.measured, result, first);
  Contradiction found{.any = !innovation_reasons(innovations).empty()};
  for (const auto& sensor : sensor_consistency(innovations))
    found.widening = std::max(found.widening, sensor.widening());
  double sum = 0.0, expected = 0.0;
  for (Index k = first; k < result.nis.size(); ++k) {
    if (!std::isfinite(result.nis[k])) continue;
    sum += result.nis[k];
    expected += result.measured[k];
  }
  if (expected > 0.0) found.excess = std::max(0.0, sum / expected - 1.0);
  return found;
}

ParameterJump jump_of(const Trial& trial) {
  const Index i = trial.unknown, last = trial.result.unknowns.mean.cols() - 1;
  const auto& [mean, deviation] = trial.result.unknowns;
  return {.unknown = i,
          .sample = trial.sample,
          .before = mean(i, trial.sample - 1),
          .after = mean(i, last),
          .deviation = std::hypot(deviation(i, trial.sample - 1), deviation(i, last))};
}

}  // namespace

JumpSearchResult find_parameter_jump(const AugmentedModel& augmented_model, const FilterInput& input,
                                     EstimationOptions options, const EstimationResult& result, Index first,
                                     double steps, StepBudget& budget) {
  const auto& history = result.unknowns_history;
  if (result.failure || history.empty()) return {};
  const auto hints = hints_of(history, first);
  if (hints.front().statistic < worth_a_run) return {};
  JumpSearch search(augmented_model, input, std::move(options), first, steps, budget);
  const Index coarse = std::max<Index>(1, input.measured.samples() / coarse_parts);
  const EstimationResult constant = search.without_change();
  std::vector<Trial> trials;
  for (const auto& hint : hints) {
    if (hint.statistic < std::max(worth_a_run, near_the_largest * hints.front().statistic)) break;
    if (trials.size() == (budget.is_limited() ? 1 : most_tried)) break;
    Trial trial = search.with_change(history.unknowns[static_cast<std::size_t>(hint.unknown)], hint.sample);
    if (search.stopped()) break;
    trials.push_back(std::move(trial));
  }
  if (trials.empty()) return {.stopped = true};
  std::ranges::sort(trials, std::greater{}, &Trial::log_likelihood);
  const auto excess_of = [&](const EstimationResult& of) { return contradiction_of(input, of, first).excess; };
  if (budget.is_limited() && excess_of(trials.front().result) > most_left * excess_of(constant)) return {};
  std::optional<Trial> best;
  for (std::size_t i = 0; i < std::min(trials.size(), most_placed); ++i) {
    Trial trial = search.placed(std::move(trials[i]), 4 * coarse, coarse);
    if (!best || trial.log_likelihood() > best->log_likelihood()) best = std::move(trial);
  }
  best = search.placed(*std::move(best), coarse / 2, 1);
  if (best->result.failure || constant.failure) return {};
  const Contradiction before = contradiction_of(input, constant, first),
                      after = contradiction_of(input, best->result, first);
  ParameterJump jump = jump_of(*best);
  jump.gain = 2.0 * (best->log_likelihood() - constant.log_likelihood) / (after.widening * after.widening);
  jump.explains = !after.any;
  const bool most_is_explained = jump.explains || after.excess < most_left * before.excess;
  const bool told = jump.gain > significant && std::abs(jump.after - jump.before) > band * jump.deviation;
  if (told && most_is_explained) return {.jump = jump};
  return {.stopped = search.stopped()};
}

}  // namespace kalfem
