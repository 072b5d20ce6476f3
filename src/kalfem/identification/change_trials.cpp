// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/change_trials.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kalfem {

using Eigen::Index;

namespace {

constexpr int walk_steps = 10;    ///< within a stretch
constexpr int most_outwards = 6;  ///< steps, doubled, until the likelihood is clearly lower
constexpr int most_moves = 4;     ///< by one step
constexpr int most_rounds = 3;
constexpr double clear = 3.7;        ///< log-likelihood by which the places beside a placed change are lower
constexpr double reference = 1.5;    ///< NIS over its degrees of freedom between that of a right and a wrong model
constexpr double clear_rise = 30.0;  ///< of the sum of what exceeds it

/// Mean of NIS over its degrees of freedom between two samples, at least 1.
double usual_nis(const EstimationResult& result, Index from, Index to) {
  double sum = 0.0, expected = 0.0;
  for (Index k = from; k < to; ++k) {
    if (!std::isfinite(result.nis[k])) continue;
    sum += result.nis[k];
    expected += result.measured[k];
  }
  return expected > 0.0 ? std::max(1.0, sum / expected) : 1.0;
}

/// The first sample from which innovations are too large, in the samples within two steps of a change that lies beside
/// the true one: before it the model is right, behind it the filter holds the wrong value, whether it was renewed too
/// early or is renewed later. The largest rise of the sum of NIS / degrees of freedom - `reference` (Page 1954,
/// Biometrika 41, 100-115), over what is usual before; nothing where it does not rise clearly.
std::optional<Index> onset(const EstimationResult& result, Index around, Index step, Index first) {
  const Index from = std::max(first, around - 2 * step), to = std::min<Index>(result.nis.size(), around + 2 * step);
  const double usual = usual_nis(result, std::max(first, from - 4 * step), from);
  double sum = 0.0, lowest = 0.0, largest_rise = clear_rise;
  Index start = from;
  std::optional<Index> found;
  for (Index k = from; k < to; ++k) {
    if (!std::isfinite(result.nis[k]) || result.measured[k] == 0) continue;
    sum += result.nis[k] / (usual * result.measured[k]) - reference;
    if (sum <= lowest) {
      lowest = sum;
      start = k + 1;
    } else if (sum - lowest > largest_rise) {
      largest_rise = sum - lowest;
      found = start;
    }
  }
  return found;
}

}  // namespace

ChangeTrials::ChangeTrials(const AugmentedModel& augmented_model, const FilterInput& input, EstimationOptions options,
                           Index first, double steps, StepBudget& budget)
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

EstimationResult ChangeTrials::without_change() {
  if (!takes_a_run()) return {};
  return estimate(augmented_model_, input_, options_);
}

ChangeTrial ChangeTrials::with_change(Index unknown, Index sample) {
  if (!takes_a_run()) return {unknown, sample, {}};
  EstimationOptions options = options_;
  options.renewals = {{unknown, sample, prior_deviation(unknown)}};
  ChangeTrial trial{unknown, sample, estimate(augmented_model_, input_, options)};
  places_[unknown][sample] = trial.log_likelihood();
  return trial;
}

EstimationResult ChangeTrials::forgetting(const std::vector<Index>& unknowns, Index stretch) {
  if (!takes_a_run()) return {};
  EstimationOptions options = options_;
  for (Index sample = stretch; sample < samples(); sample += stretch)
    for (const Index unknown : unknowns) options.renewals.push_back({unknown, sample, prior_deviation(unknown)});
  return estimate(augmented_model_, input_, options);
}

EstimationResult ChangeTrials::walking(Index unknown, Index stretch, double variance) {
  if (!takes_a_run()) return {};
  EstimationOptions options = options_;
  const Index every = std::max<Index>(1, stretch / walk_steps);
  const double step = std::sqrt(variance * static_cast<double>(every) / static_cast<double>(stretch));
  for (Index sample = every; sample < samples(); sample += every) options.renewals.push_back({unknown, sample, step});
  return estimate(augmented_model_, input_, options);
}

ChangeTrial ChangeTrials::placed(ChangeTrial best, Index step) {
  Index before = -1;
  for (int i = 0; i < most_rounds && best.sample != before && !stopped_; ++i) {
    before = best.sample;
    follow_onset(best, step);
    if (!budget_.is_limited()) halve_steps(best, step, std::max<Index>(1, step / 8));
    for (const Index side : {-1, 1}) go_outwards(best, side, std::max<Index>(1, step / 4));
  }
  halve_steps(best, step / 8, 1);
  return best;
}

void ChangeTrials::follow_onset(ChangeTrial& best, Index step) {
  const auto is_open = [&](Index sample) {
    return sample > first_ && sample < samples() && !places_[best.unknown].contains(sample);
  };
  for (int i = 0; i < most_moves && !stopped_; ++i) {
    const auto at = onset(best.result, best.sample, step, first_);
    if (!at || !is_open(*at)) return;
    if (tries(*at, best)) continue;
    // States that the wrong value left behind may hide the onset: then the change is between the two.
    const Index middle = (*at + best.sample) / 2;
    if (!is_open(middle) || !tries(middle, best)) return;
  }
}

/// By doubled steps until the likelihood is clearly lower.
void ChangeTrials::go_outwards(ChangeTrial& best, Index side, Index reach) {
  const auto bounded = [&] {
    return std::ranges::any_of(places_[best.unknown], [&](const auto& place) {
      return side * (place.first - best.sample) > 0 && best.log_likelihood() - place.second > clear;
    });
  };
  for (int i = 0; i < most_outwards && !stopped_ && !bounded(); ++i, reach *= 2) {
    const Index sample = best.sample + side * reach;
    if (sample <= first_ || sample >= samples()) return;
    if (!places_[best.unknown].contains(sample)) tries(sample, best);
  }
}

void ChangeTrials::halve_steps(ChangeTrial& best, Index from, Index to) {
  for (Index reach = from; reach >= to; reach /= 2)
    for (int i = 0; i < most_moves && moves(best, reach); ++i) {
    }
}

bool ChangeTrials::moves(ChangeTrial& best, Index reach) {
  for (const Index sample : {best.sample - reach, best.sample + reach}) {
    if (stopped_ || sample <= first_ || sample >= samples() || places_[best.unknown].contains(sample)) continue;
    if (tries(sample, best)) return true;
  }
  return false;
}

bool ChangeTrials::tries(Index sample, ChangeTrial& best) {
  ChangeTrial moved = with_change(best.unknown, sample);
  if (stopped_ || !(moved.log_likelihood() > best.log_likelihood())) return false;
  best = std::move(moved);
  return true;
}

double ChangeTrials::prior_deviation(Index unknown) const {
  const auto& of = augmented_model_.options().unknowns[static_cast<std::size_t>(unknown)];
  return of.deviation / of.transform.slope(of.transform.to_state(of.initial));
}

bool ChangeTrials::takes_a_run() {
  if (allowed_ > 0) return allowed_-- > 0;
  if (!stopped_) stopped_ = !budget_.take(steps_);
  return !stopped_;
}

std::pair<Index, Index> interval_of_place(const ChangeTrials::Places& places, Index place, double unlikely, Index first,
                                          Index last) {
  Index earliest = first, latest = last;
  const double best = places.at(place);
  for (const auto& [sample, height] : places) {
    if (best - height < unlikely) continue;
    if (sample < place) earliest = std::max(earliest, sample);
    if (sample > place) latest = std::min(latest, sample);
  }
  return {std::max(first, std::min(earliest, place - 1)), std::min(last, std::max(latest, place + 1))};
}

}  // namespace kalfem
