// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameter_jumps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <tuple>

#include "kalfem/identification/change_hints.hpp"
#include "kalfem/identification/change_levels.hpp"
#include "kalfem/identification/change_trials.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double worth_a_run = 16.0;      ///< largest statistic of the scores
constexpr double near_the_largest = 0.2;  ///< statistic of another unknown that is tried too
constexpr std::size_t most_tried = 4;     ///< unknowns, of which the best
constexpr std::size_t most_placed = 2;    ///< are placed
constexpr int placing_runs = 8;           ///< for the time of a change that explains, beyond a limited budget
constexpr double significant = 30.0;      ///< gain
constexpr double slight = 0.3;            ///< excess of NIS about which scores still tell where
constexpr double most_left = 0.5;         ///< of the excess of NIS, where the change explains it
constexpr double little_left = 0.05;      ///< of it, where nothing else is to be explained
constexpr double unlikely = 3.7;          ///< log-likelihood below the largest, out of the interval of a place
constexpr Index fewest_behind = 10;       ///< samples behind a change: a few large innovations at the end are none
constexpr double band = 1.96;             ///< standard deviations of a change
constexpr Index stretches = 40;           ///< of a run that forgets
constexpr double clear_levels = 10.0;     ///< gain of two levels, or of a slow course, over one level
constexpr double clear_shape = 10.0;      ///< gain by which levels alone tell a jump from a drift,
constexpr double clear_part = 0.05;       ///< and part of it

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

/// What the stretches of a run that forgets say of one unknown.
struct UnknownLevels {
  Index unknown = 0;
  StretchLevels levels;
  LevelFits fits;

  [[nodiscard]] Index start_of_second_level() const {
    return levels.end[static_cast<std::size_t>(levels.second_level)] - levels.length;
  }
  /// The middle of the stretch within which the level changes.
  [[nodiscard]] Index place() const {
    return levels.end[static_cast<std::size_t>(fits.place)] - std::max<Index>(1, levels.length / 2);
  }
};

class ChangeSearch {
public:
  ChangeSearch(const AugmentedModel& augmented_model, const FilterInput& input, const EstimationOptions& options,
               const EstimationResult& result, Index first, double steps, StepBudget& budget)
      : augmented_model_(augmented_model),
        input_(input),
        result_(result),
        unknowns_(result.unknowns_history.unknowns),
        hints_(change_hints(result.unknowns_history, first)),
        limited_(budget.is_limited()),
        stretch_(std::max<Index>(1, input.measured.samples() / stretches)),
        trials_(augmented_model, input, options, first, steps, budget) {}

  JumpSearchResult run() {
    if (hints_.empty() || hints_.front().statistic < worth_a_run) return {};
    const auto clearest = clearest_levels();
    const bool contradictory = contradiction(result_).excess > slight;
    // What no course of the unknowns explains is another mistake, which the rest of the budget is for.
    const bool another_mistake = !clearest || left_by_forgetting_ > most_left;
    if (limited_ && contradictory && another_mistake) return {.stopped = trials_.stopped()};
    // Within a limited budget a change is compared with the run of the estimate itself, where that contradicts the
    // record by more than what fewer substeps add.
    const EstimationResult constant = limited_ && contradictory ? result_ : trials_.without_change();
    const UnknownLevels levels = sharpened(clearest);
    const bool ambiguous =
        std::abs(levels.fits.slow - levels.fits.step) < std::max(clear_shape, clear_part * levels.fits.best());
    const bool slow = levels.fits.is_slow() && !ambiguous;
    std::optional<ParameterJump> drift, jump;
    if (slow) drift = drift_of(levels, constant);
    if (!drift) jump = jump_of(levels, clearest.has_value(), constant);
    // Half of what a drift contradicts would be explained by a jump of the same unknown, too.
    if (slow && jump && jump->unknown == levels.unknown) jump.reset();
    const bool may_be_either = ambiguous && (levels.fits.is_slow() || !jump || !jump->explains);
    if (may_be_either && !trials_.stopped()) drift = drift_of(levels, constant);
    const bool drifts = drift && (!jump || drift->gain > jump->gain);
    if (drifts || jump) return {.jump = drifts ? drift : jump};
    return {.stopped = trials_.stopped()};
  }

private:
  [[nodiscard]] Contradiction contradiction(const EstimationResult& result) const {
    return contradiction_of(input_, result, trials_.first());
  }

  /// The part of the excess that a run with a change leaves. What fewer substeps than those of the estimate add is in
  /// both, and none of its matter.
  [[nodiscard]] double excess_left(const Contradiction& after, const Contradiction& constant) const {
    const double before = std::min(constant.excess, contradiction(result_).excess), added = constant.excess - before;
    return std::max(0.0, after.excess - added) / std::max(before, 1e-12);
  }

  /// Whether a run with a change leaves so little that nothing else is wrong.
  [[nodiscard]] bool leaves_little(const EstimationResult& with_it, const EstimationResult& constant) const {
    const Contradiction before = contradiction(constant), after = contradiction(with_it);
    const double stated = std::min(before.excess, contradiction(result_).excess);
    return !after.any || excess_left(after, before) * stated < slight;
  }

  /// Of each of these unknowns, from a run that renews all of them.
  std::vector<UnknownLevels> levels_by(const std::vector<Index>& unknowns) {
    const EstimationResult forgetting = trials_.forgetting(unknowns, stretch_);
    std::vector<UnknownLevels> all;
    if (trials_.stopped()) return all;
    if (unknowns.size() == unknowns_.size())
      left_by_forgetting_ = excess_left(contradiction(forgetting), contradiction(result_));
    for (const Index unknown : unknowns) {
      UnknownLevels each{.unknown = unknown};
      each.levels = levels_of(forgetting, augmented_model_.layout().unknown() + unknown,
                              trials_.prior_deviation(unknown), stretch_, trials_.first());
      each.fits = fits_of(each.levels);
      all.push_back(std::move(each));
    }
    return all;
  }

  /// About a model that holds a changing unknown constant, scores are those of a compromise, which may suit neither
  /// value: a run that forgets tells which unknown changes, where one does clearly.
  std::optional<UnknownLevels> clearest_levels() {
    auto all = levels_by(unknowns_);
    const auto clearest = std::ranges::max_element(all, {}, [](const auto& each) { return each.fits.best(); });
    if (clearest == all.end() || clearest->fits.best() < clear_levels) return std::nullopt;
    const auto other = std::ranges::max_element(all, {}, [](const auto& each) { return each.levels.contrast; });
    if (other != clearest && other->levels.contrast > static_cast<double>(other->levels.value.size()))
      by_contrast_ = ChangeHint{other->unknown, other->start_of_second_level(), 0.0};
    return std::move(*clearest);
  }

  /// The levels of the unknown that is clearest, or that the scores name first, with all others held constant: they are
  /// known better then. Within a limited budget only where those of the first run are not clear.
  UnknownLevels sharpened(const std::optional<UnknownLevels>& clearest) {
    if (clearest && (limited_ || unknowns_.size() == 1)) return *clearest;
    const Index unknown = clearest ? clearest->unknown : hints_.front().unknown;
    auto levels = levels_by({unknown});
    if (!levels.empty() && levels.front().fits.best() > 0.0) return std::move(levels.front());
    return clearest ? *clearest : UnknownLevels{.unknown = unknown};
  }

  /// The unknown as a random walk, if that is told by the run and leaves nothing to explain: a walk takes up a part of
  /// what any mistake does, as process noise would.
  std::optional<ParameterJump> drift_of(const UnknownLevels& levels, const EstimationResult& constant) {
    if (!(levels.fits.walk > 0.0) || levels.levels.value.size() < 2) return std::nullopt;
    const EstimationResult walking = trials_.walking(levels.unknown, stretch_, levels.fits.walk);
    if (trials_.stopped()) return std::nullopt;
    const auto course = smoothed_walk(levels.levels, levels.fits.walk, levels.fits.scatter);
    Index lowest = 0, highest = 0;
    course.value.minCoeff(&lowest);
    course.value.maxCoeff(&highest);
    const auto [from, to] = std::minmax(lowest, highest);
    const auto middle_of = [&](Index k) { return levels.levels.end[static_cast<std::size_t>(k)] - stretch_ / 2 - 1; };
    const auto& transform = augmented_model_.options().unknowns[static_cast<std::size_t>(levels.unknown)].transform;
    ParameterJump drift{.unknown = levels.unknown, .earliest = middle_of(from), .latest = middle_of(to)};
    drift.before = transform.to_parameter(course.value[from]);
    drift.after = transform.to_parameter(course.value[to]);
    drift.deviation = std::hypot(transform.slope(course.value[from]) * course.deviation[from],
                                 transform.slope(course.value[to]) * course.deviation[to]);
    const auto found = told(drift, walking, constant);
    return found && leaves_little(walking, constant) ? found : std::nullopt;
  }

  std::optional<ParameterJump> jump_of(const UnknownLevels& levels, bool clear, const EstimationResult& constant) {
    std::vector<ChangeTrial> trials = first_trials(levels, clear);
    if (trials.empty()) return std::nullopt;
    if (limited_) {
      auto best = explaining(std::move(trials.front()), constant);
      if (!best) return std::nullopt;
      trials.front() = *std::move(best);
      trials_.allow_runs(placing_runs);
    }
    ChangeTrial best;
    for (std::size_t i = 0; i < std::min(trials.size(), limited_ ? 1 : most_placed); ++i) {
      ChangeTrial placed = trials_.placed(std::move(trials[i]), stretch_);
      if (i == 0 || placed.log_likelihood() > best.log_likelihood()) best = std::move(placed);
    }
    if (best.result.failure || input_.measured.samples_used() - best.sample < fewest_behind) return std::nullopt;
    const auto& [mean, deviation] = best.result.unknowns;
    const Index last = mean.cols() - 1;
    ParameterJump jump{.unknown = best.unknown, .sample = best.sample};
    jump.before = mean(best.unknown, best.sample - 1);
    jump.after = mean(best.unknown, last);
    jump.deviation = std::hypot(deviation(best.unknown, best.sample - 1), deviation(best.unknown, last));
    const double widening = contradiction(best.result).widening;
    std::tie(jump.earliest, jump.latest) = interval_of_place(trials_.places(best.unknown), best.sample,
                                                             unlikely * widening * widening, trials_.first(), last);
    return told(jump, best.result, constant);
  }

  /// The changes to try, the likeliest first. Within a limited budget one: that of clear levels or, of a run that
  /// hardly contradicts itself, that of its scores.
  std::vector<ChangeTrial> first_trials(const UnknownLevels& levels, bool clear) {
    std::vector<ChangeHint> hints = hints_;
    const double least = std::max(worth_a_run, near_the_largest * hints.front().statistic);
    std::erase_if(hints, [&](const ChangeHint& hint) { return hint.statistic < least; });
    if (clear || levels.fits.step > 0.0) hints.insert(hints.begin(), {levels.unknown, levels.place(), 0.0});
    hints.resize(std::min(hints.size(), limited_ ? 1 : most_tried));
    if (by_contrast_) hints.push_back(*by_contrast_);
    std::vector<ChangeTrial> trials;
    for (const auto& hint : hints) {
      ChangeTrial trial = trials_.with_change(hint.unknown, hint.sample);
      if (trials_.stopped()) break;
      trials.push_back(std::move(trial));
    }
    std::ranges::sort(trials, std::greater{}, &ChangeTrial::log_likelihood);
    std::vector<ChangeTrial> best;  // of each unknown
    for (auto& trial : trials)
      if (std::ranges::find(best, trial.unknown, &ChangeTrial::unknown) == best.end()) best.push_back(std::move(trial));
    return best;
  }

  /// The likeliest change, if it leaves no more than half of the contradiction: the first of the trials, otherwise one
  /// of any unknown near where innovations become too large.
  std::optional<ChangeTrial> explaining(ChangeTrial first, const EstimationResult& constant) {
    const auto leaves_most = [&](const ChangeTrial& trial) {
      return excess_left(contradiction(trial.result), contradiction(constant)) > most_left;
    };
    trials_.follow_onset(first, stretch_);
    if (!leaves_most(first)) return first;
    const Index of_first = first.unknown, place = first.sample;
    ChangeTrial best = std::move(first);
    for (Index unknown = 0; unknown < std::ssize(unknowns_) && !trials_.stopped(); ++unknown) {
      if (unknown == of_first) continue;
      ChangeTrial trial = trials_.with_change(unknown, place);
      if (trials_.stopped()) break;
      trials_.follow_onset(trial, stretch_);
      if (trial.log_likelihood() > best.log_likelihood()) best = std::move(trial);
    }
    return leaves_most(best) ? std::nullopt : std::optional(std::move(best));
  }

  /// The change with its gain, where it is significant and leaves no more than half of the contradiction.
  [[nodiscard]] std::optional<ParameterJump> told(ParameterJump change, const EstimationResult& with_it,
                                                  const EstimationResult& constant) const {
    if (with_it.failure || constant.failure) return std::nullopt;
    const Contradiction before = contradiction(constant), after = contradiction(with_it);
    change.gain = 2.0 * (with_it.log_likelihood - constant.log_likelihood) / (after.widening * after.widening);
    const double left = excess_left(after, before);
    change.explains = !after.any || (left < little_left && leaves_little(with_it, constant));
    const bool most_is_explained = !after.any || left < most_left;
    const bool changes = std::abs(change.after - change.before) > band * change.deviation;
    return change.gain > significant && changes && most_is_explained ? std::optional(change) : std::nullopt;
  }

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  const EstimationResult& result_;
  const std::vector<Index>& unknowns_;
  std::vector<ChangeHint> hints_;
  std::optional<ChangeHint> by_contrast_ = {};  ///< another unknown, whose estimates show two levels most clearly
  double left_by_forgetting_ = 0.0;             ///< of the excess of NIS, where all unknowns may take any course
  bool limited_;
  Index stretch_;
  ChangeTrials trials_;
};

}  // namespace

JumpSearchResult find_parameter_jump(const AugmentedModel& augmented_model, const FilterInput& input,
                                     const EstimationOptions& options, const EstimationResult& result, Index first,
                                     double steps, StepBudget& budget) {
  if (result.failure || result.unknowns_history.empty()) return {};
  return ChangeSearch(augmented_model, input, options, result, first, steps, budget).run();
}

}  // namespace kalfem
