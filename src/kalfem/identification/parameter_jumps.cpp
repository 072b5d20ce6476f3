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
constexpr double slight = 0.3;            ///< excess of NIS about which scores still tell where
constexpr double most_left = 0.5;         ///< of the excess of NIS, where the change explains it
constexpr double unlikely = 3.7;          ///< log-likelihood below the largest, out of the interval of a place
constexpr double band = 1.96;             ///< standard deviations of a change
constexpr double trimmed = 0.02;          ///< of an unknown's information at either end
constexpr Index stretches = 40;           ///< of a run that forgets
constexpr std::size_t fewest_stretches = 8;
constexpr Index coarse_parts = 64;  ///< of the record: the step to which every unknown's change is placed

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
    EstimationOptions options = options_;
    options.renewals = {{unknown, sample, prior_deviation(unknown)}};
    Trial trial{unknown, sample, estimate(augmented_model_, input_, options)};
    tried_.push_back({unknown, sample, trial.log_likelihood()});
    return trial;
  }

  /// A run that forgets: all these unknowns are renewed after every stretch of so many samples.
  EstimationResult forgetting(const std::vector<Index>& unknowns, Index stretch) {
    if (!takes_a_run()) return {};
    EstimationOptions options = options_;
    for (Index sample = stretch; sample < input_.measured.samples(); sample += stretch)
      for (const Index unknown : unknowns) options.renewals.push_back({unknown, sample, prior_deviation(unknown)});
    return estimate(augmented_model_, input_, options);
  }

  /// Moves the change to the largest likelihood by steps that are halved from `step` down to `finest`. A step is
  /// repeated a few times only: where the likelihood keeps rising, the change is nowhere near.
  Trial placed(Trial best, Index step, Index finest) {
    for (; step >= finest && !stopped_; step /= 2) {
      for (int i = 0; i < most_moves && moves(best, step); ++i) {
      }
      resolution_ = stopped_ ? 2 * step : step;
    }
    return best;
  }

  /// Sets the interval of its sample by what was tried around it, no narrower than the steps by which it was placed.
  void set_interval(double log_likelihood, double widening, ParameterJump& jump) const {
    jump.earliest = first_;
    jump.latest = input_.measured.samples() - 1;
    for (const auto& [unknown, sample, other] : tried_) {
      if (unknown != jump.unknown || log_likelihood - other < unlikely * widening * widening) continue;
      if (sample < jump.sample) jump.earliest = std::max(jump.earliest, sample);
      if (sample > jump.sample) jump.latest = std::min(jump.latest, sample);
    }
    jump.earliest = std::max(first_, std::min(jump.earliest, jump.sample - resolution_));
    jump.latest = std::min(input_.measured.samples() - 1, std::max(jump.latest, jump.sample + resolution_));
  }

private:
  struct Tried {
    Index unknown = 0, sample = 0;
    double log_likelihood = 0.0;
  };

  /// In the filter's state.
  [[nodiscard]] double prior_deviation(Index unknown) const {
    const auto& of = augmented_model_.options().unknowns[static_cast<std::size_t>(unknown)];
    return of.deviation / of.transform.slope(of.transform.to_state(of.initial));
  }

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
  Index resolution_ = 1;  ///< samples within which the last place is the best
  std::vector<Tried> tried_;
};

/// The split of a series into two levels that leaves the least: its place, and the F statistic of the levels.
std::pair<Index, double> two_levels(const VectorXd& values, const VectorXd& weights) {
  const Index count = values.size();
  const double all = weights.dot(values) / weights.sum();
  const double total = weights.dot((values.array() - all).square().matrix());
  std::pair<Index, double> best{0, 0.0};
  double weight = 0.0, sum = 0.0;
  for (Index k = 1; k < count; ++k) {
    weight += weights[k - 1];
    sum += weights[k - 1] * values[k - 1];
    const double others = weights.sum() - weight, before = sum / weight, after = (weights.dot(values) - sum) / others;
    const double between = weight * others / weights.sum() * (after - before) * (after - before);
    const double statistic = static_cast<double>(count - 2) * between / std::max(total - between, 1e-12 * total);
    if (statistic > best.second) best = {k, statistic};
  }
  return best;
}

/// Where a run that forgets says that an unknown takes another value: about a model that holds it constant, scores are
/// those of a compromise, which may suit neither value. The unknown whose stretches show two levels most clearly, where
/// these explain most of its scatter.
std::optional<Hint> hint_of_stretches(const EstimationResult& forgetting, const std::vector<Index>& unknowns,
                                      Index stretch, Index first) {
  const auto& [mean, deviation] = forgetting.unknowns;
  std::vector<Index> ends;
  for (Index end = stretch; end <= mean.cols(); end += stretch)
    if (end > first) ends.push_back(end - 1);
  if (forgetting.failure || ends.size() < fewest_stretches) return std::nullopt;  // none of a run that was not allowed
  Hint clearest;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const VectorXd values = mean(unknowns[i], ends).transpose(), spread = deviation(unknowns[i], ends).transpose();
    const auto [place, statistic] = two_levels(values, spread.cwiseMax(1e-300).cwiseAbs2().cwiseInverse());
    if (place > 0 && statistic > clearest.statistic)
      clearest = {static_cast<Index>(i), ends[static_cast<std::size_t>(place - 1)] + 1, statistic};
  }
  const auto freedom = static_cast<double>(ends.size() - 2);
  return clearest.statistic > freedom ? std::optional(clearest) : std::nullopt;  // R^2 above one half
}

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

/// The unknowns and places to try, the likeliest first. Within a limited budget one: that of clear levels or, of a run
/// that hardly contradicts itself, that of its scores.
std::vector<Hint> hints_to_try(std::vector<Hint> of_scores, const std::optional<Hint>& of_stretches, bool limited,
                               double excess) {
  const double least = std::max(worth_a_run, near_the_largest * of_scores.front().statistic);
  std::erase_if(of_scores, [&](const Hint& hint) { return hint.statistic < least; });
  if (limited && of_stretches) return {*of_stretches};
  if (limited && excess > slight) return {};
  if (of_stretches) of_scores.insert(of_scores.begin(), *of_stretches);
  of_scores.resize(std::min(of_scores.size(), limited ? 1 : most_tried));
  return of_scores;
}

/// The changes that these hints name, the likeliest first; fewer where the budget ends.
std::vector<Trial> trials_of(const std::vector<Hint>& hints, const std::vector<Index>& unknowns, JumpSearch& search) {
  std::vector<Trial> trials;
  for (const auto& hint : hints) {
    Trial trial = search.with_change(unknowns[static_cast<std::size_t>(hint.unknown)], hint.sample);
    if (search.stopped()) break;
    trials.push_back(std::move(trial));
  }
  std::ranges::sort(trials, std::greater{}, &Trial::log_likelihood);
  return trials;
}

/// Places the best ones, first coarsely where the budget allows that.
Trial placed(std::vector<Trial> trials, Index samples, bool limited, JumpSearch& search) {
  const Index coarse = std::max<Index>(1, samples / coarse_parts), stretch = std::max<Index>(1, samples / stretches);
  if (limited) return search.placed(std::move(trials.front()), std::max<Index>(1, stretch / 2), 1);
  std::optional<Trial> best;
  for (std::size_t i = 0; i < std::min(trials.size(), most_placed); ++i) {
    Trial trial = search.placed(std::move(trials[i]), 4 * coarse, coarse);
    if (!best || trial.log_likelihood() > best->log_likelihood()) best = std::move(trial);
  }
  return search.placed(*std::move(best), coarse / 2, 1);
}

}  // namespace

JumpSearchResult find_parameter_jump(const AugmentedModel& augmented_model, const FilterInput& input,
                                     EstimationOptions options, const EstimationResult& result, Index first,
                                     double steps, StepBudget& budget) {
  const auto& history = result.unknowns_history;
  if (result.failure || history.empty()) return {};
  const std::vector<Hint> of_scores = hints_of(history, first);
  if (of_scores.front().statistic < worth_a_run) return {};
  const bool limited = budget.is_limited();
  const auto excess_of = [&](const EstimationResult& of) { return contradiction_of(input, of, first).excess; };
  JumpSearch search(augmented_model, input, std::move(options), first, steps, budget);
  const Index samples = input.measured.samples(), stretch = std::max<Index>(1, samples / stretches);
  const auto of_stretches =
      hint_of_stretches(search.forgetting(history.unknowns, stretch), history.unknowns, stretch, first);
  const auto hints = hints_to_try(of_scores, of_stretches, limited, excess_of(result));
  if (hints.empty()) return {.stopped = search.stopped()};
  const EstimationResult constant = search.without_change();
  std::vector<Trial> trials = trials_of(hints, history.unknowns, search);
  if (trials.empty()) return {.stopped = true};
  if (limited && excess_of(trials.front().result) > most_left * excess_of(constant)) return {};
  const Trial best = placed(std::move(trials), samples, limited, search);
  if (best.result.failure || constant.failure) return {};
  const Contradiction before = contradiction_of(input, constant, first),
                      after = contradiction_of(input, best.result, first);
  ParameterJump jump = jump_of(best);
  jump.gain = 2.0 * (best.log_likelihood() - constant.log_likelihood) / (after.widening * after.widening);
  jump.explains = !after.any;
  search.set_interval(best.log_likelihood(), after.widening, jump);
  const bool most_is_explained = jump.explains || after.excess < most_left * before.excess;
  const bool told = jump.gain > significant && std::abs(jump.after - jump.before) > band * jump.deviation;
  if (told && most_is_explained) return {.jump = jump};
  return {.stopped = search.stopped()};
}

}  // namespace kalfem
