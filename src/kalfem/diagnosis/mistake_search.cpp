// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/mistake_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/diagnosis/evidence.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double worth_refining = 0.2;  ///< part of the best's rise
constexpr double worth_looking = 0.1;   ///< part of the best's rise: a second law that is looked into
constexpr double nearly_as_good = 0.9;  ///< part of the best's rise
constexpr double finest_part = 0.02;    ///< of a sample
constexpr double worth_telling = 0.01;  ///< part of the rise: a further force of a law
constexpr double as_good = 0.002;       ///< log-likelihood per measured value by which equal explanations differ

double moved(const Hypothesis& hypothesis, double value, double steps) {
  return hypothesis.search == Search::factor ? value * std::exp(steps * hypothesis.step)
                                             : value + steps * hypothesis.step;
}

}  // namespace

MistakeSearch::MistakeSearch(DiagnosisInput input, const TrialPlan& plan) : input_(std::move(input)), plan_(plan) {
  input_.record = first_samples(std::move(input_.record), plan.samples);
  auto problem = std::make_shared<EstimationProblem>(*input_.problem);
  problem->settings.substeps = plan.substeps;
  input_.problem = std::move(problem);
  base_ = input_.run();
  options_ = {.filter = base_.choice.filter,
              .unscented = input_.options.unscented,
              .state_deviations = false,
              .adaptive_noise = input_.options.adaptive_noise};
  given_ = after_more_passes(score_of({base_, 0.0}, options_, {}), base_, options_);
  given_.samples = measured_samples(plan_.samples);  // also of a run that stopped
}

Undo MistakeSearch::undoing(std::size_t h) const {
  return [correct = hypotheses_[h].correct, value = values_[h]](const DiagnosisInput& given) {
    return correct(given, value);
  };
}

Diagnosis MistakeSearch::run(const std::function<bool(const Hypothesis&)>& wanted) {
  Diagnosis diagnosis{.duration = static_cast<double>(input_.record.samples()) / input_.record.sample_rate,
                      .failed = !std::isfinite(given_.log_likelihood),
                      .mean_nis = given_.mean_nis,
                      .expected_nis = given_.expected_nis,
                      .widening = given_.widening};
  auto candidates = all_candidates(input_, base_, options_);
  hypotheses_ = std::move(candidates.hypotheses);
  if (wanted) std::erase_if(hypotheses_, [&](const Hypothesis& each) { return !wanted(each); });
  scores_.resize(hypotheses_.size());
  values_.resize(hypotheses_.size());
  race();
  if (!is_explained_without_laws()) look_into_laws(candidates.motion);
  refine_the_best();
  collect(diagnosis);
  return diagnosis;
}

/// The first round takes every first guess, later ones the best of each, after a search of the leading ones' numbers on
/// the short part. Who is left behind keeps no score.
void MistakeSearch::race() {
  std::size_t starts = 0;
  for (const auto& hypothesis : hypotheses_)
    starts += hypothesis.starts.size() + (hypothesis.search == Search::factor ? 1 : 0);
  const auto rounds = plan_.rounds(hypotheses_.size(), starts);
  std::vector<std::size_t> order(hypotheses_.size());
  for (std::size_t h = 0; h < order.size(); ++h) order[h] = h;
  for (std::size_t r = 0; r < rounds.size(); ++r) {
    samples_ = rounds[r].samples;
    const double unchanged = r == 0 ? log_likelihood_unchanged() : 0.0;
    order.resize(std::min(order.size(), rounds[r].hypotheses));
    std::vector<TrialScore> before(hypotheses_.size());
    std::swap(scores_, before);
    for_each_index(order.size(), processors(), [&](std::size_t i) {
      const std::size_t h = order[i];
      if (r == 0)
        try_between(h, unchanged);
      else
        try_value(h, values_[h]);
    });
    order = best_first();
    if (r + 1 == rounds.size() || !plan_.searches_early) continue;
    const std::size_t leading = std::min(order.size(), plan_.finalists);
    for_each_index(leading, processors(), [&](std::size_t i) { refine(order[i], plan_.most_steps); });
    order = best_first();
  }
}

/// Whether the best hypothesis leaves nothing, and wrong laws explain far less: they need not be looked into.
bool MistakeSearch::is_explained_without_laws() {
  if (hypotheses_.empty()) return true;
  const std::size_t best = best_first().front();
  const auto is_as_good = [&](std::size_t h) {
    return hypotheses_[h].code == "wrong_law" && gain(h) > nearly_as_good * gain(best);
  };
  for (std::size_t h = 0; h < hypotheses_.size(); ++h)
    if (is_as_good(h)) return false;
  refine(best, plan_.most_steps);
  settle(best);
  return explains(best) && scores_[best].leaves_nothing();
}

/// Hypotheses of a wrong law stand for many forces together, enough to tell which connector is in question. Those of
/// the most likely ones give way to the forces that make it up, one after another while each explains far more.
void MistakeSearch::look_into_laws(const std::vector<ConnectorMotion>& motion) {
  std::vector<std::size_t> laws;
  double best = 0.0;
  for (const std::size_t h : best_first()) {
    if (explains(h)) best = std::max(best, gain(h));
    if (hypotheses_[h].code == "wrong_law" && laws.size() < plan_.laws &&
        (laws.empty() || gain(h) >= worth_looking * best))
      laws.push_back(h);
  }
  for (const std::size_t h : laws) {
    const auto& connectors = input_.parts.connectors;
    const auto at = std::ranges::find(connectors, hypotheses_[h].subject, &ConnectorDescription::name);
    add_terms(*at, motion[static_cast<std::size_t>(at - connectors.begin())]);
    scores_[h] = {};
  }
}

void MistakeSearch::add_terms(const ConnectorDescription& connector, const ConnectorMotion& motion) {
  std::vector<LawTerm> left = law_terms(motion);
  std::vector<ChosenTerm> known;
  double before = 0.0;
  while (known.size() < plan_.terms && !left.empty()) {
    const std::size_t first = hypotheses_.size();
    for (const auto& term : left) {
      auto with_it = known;
      with_it.push_back({term});
      add(lacking_terms(input_, connector, with_it, known.size()));
    }
    for_each_index(left.size(), processors(), [&](std::size_t i) { try_starts(first + i); });
    std::size_t best = 0;
    for (std::size_t i = 0; i < left.size(); ++i)
      if (gain(first + i) > gain(first + best)) best = i;
    if (left[best].searched()) refine(first + best, plan_.most_steps / 2);
    const double reached = gain(first + best);
    if (!(reached > before + std::max(significant_rise, worth_telling * before))) break;
    before = reached;
    known.push_back({left[best], values_[first + best]});
    left = the_next(left, first, best);
  }
  settle_places(connector, known);
}

/// The forces that explained most after the best one, each with the number at which it did.
std::vector<LawTerm> MistakeSearch::the_next(const std::vector<LawTerm>& terms, std::size_t first,
                                             std::size_t best) const {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < terms.size(); ++i)
    if (i != best) order.push_back(i);
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return gain(first + i); });
  if (order.size() > plan_.next_terms) order.resize(plan_.next_terms);
  std::vector<LawTerm> next;
  for (const std::size_t i : order) {
    next.push_back(terms[i]);
    if (next.back().searched() && values_[first + i] != 0.0) next.back().starts = {values_[first + i]};
  }
  return next;
}

/// The numbers of earlier forces again, beside those that came after them.
void MistakeSearch::settle_places(const ConnectorDescription& connector, std::vector<ChosenTerm> known) {
  for (std::size_t i = known.size(); i-- > 0;) {
    if (!known[i].term.searched() || i + 1 == known.size()) continue;
    known[i].term.starts = {known[i].place};
    add(lacking_terms(input_, connector, known, i));
    try_starts(hypotheses_.size() - 1);
    refine(hypotheses_.size() - 1, plan_.most_steps / 2);
    known[i].place = values_.back();
  }
}

void MistakeSearch::add(Hypothesis hypothesis) {
  hypotheses_.push_back(std::move(hypothesis));
  scores_.emplace_back();
  values_.push_back(0.0);
}

void MistakeSearch::try_starts(std::size_t h) {
  for (const double start : hypotheses_[h].starts) try_value(h, start);
}

/// Tries the first guesses, and of a factor, which is no change at 1, also where the parabola through the
/// log-likelihoods there and at the nearest guesses below and above is largest.
void MistakeSearch::try_between(std::size_t h, double unchanged) {
  const Hypothesis& hypothesis = hypotheses_[h];
  std::optional<double> below, above;  // logarithms of guesses
  double of_below = 0.0, of_above = 0.0;
  for (const double start : hypothesis.starts) {
    const double found = try_value(h, start), u = start > 0.0 ? std::log(start) : 0.0;
    if (u < 0.0 && (!below || u > *below)) below = u, of_below = found;
    if (u > 0.0 && (!above || u < *above)) above = u, of_above = found;
  }
  if (hypothesis.search != Search::factor || !below || !above) return;
  const double a = *below, b = *above, left = of_below - unchanged, right = of_above - unchanged;
  const double determinant = a * b * (b - a);
  const double slope = (left * b * b - right * a * a) / determinant, curvature = (right * a - left * b) / determinant;
  if (!(std::isfinite(slope) && curvature < 0.0)) return;
  const double largest = std::clamp(-0.5 * slope / curvature, 2.0 * a, 2.0 * b);
  if (0.5 * slope * largest > significant_rise) try_value(h, std::exp(largest));
}

/// Of the run as given, over the samples that the trials see.
double MistakeSearch::log_likelihood_unchanged() const {
  if (samples_ == plan_.samples) return given_.log_likelihood;
  return score_of(first_part({base_, 0.0}, samples_), options_, measured_samples(samples_)).log_likelihood;
}

/// Keeps the value if it explains the record better than those before; its log-likelihood. A correction that the
/// problem does not admit (a negative mass) explains nothing.
double MistakeSearch::try_value(std::size_t h, double value) {
  TrialScore score;
  try {
    const Correction corrected = hypotheses_[h].correct(input_, value);
    score = score_of(first_part({corrected.input.run(), corrected.log_jacobian}, samples_), options_,
                     measured_samples(samples_));
  } catch (const InvalidInput&) {
  }
  const double found = score.log_likelihood;
  if (!(found > scores_[h].log_likelihood)) return found;
  scores_[h] = std::move(score);
  values_[h] = value;
  return found;
}

/// Of each channel, among the first samples of what the filter learns from.
Eigen::VectorXi MistakeSearch::measured_samples(Index first) const {
  const auto& measured = base_.input.measured;
  return measured.values.leftCols(std::min(first, measured.samples_used()))
      .array()
      .isFinite()
      .rowwise()
      .count()
      .cast<int>();
}

double MistakeSearch::gain(std::size_t h) const {
  const double n = std::max(2.0, static_cast<double>(given_.samples.sum()));
  const double before = std::isfinite(given_.log_likelihood) ? given_.log_likelihood : lowest();
  return scores_[h].log_likelihood - before - 0.5 * hypotheses_[h].fitted * std::log(n);
}

/// Where the filter failed as it was given, every hypothesis under which it does not is measured from the worst.
double MistakeSearch::lowest() const {
  double lowest = 0.0;
  for (const auto& score : scores_)
    if (std::isfinite(score.log_likelihood)) lowest = std::min(lowest, score.log_likelihood);
  return lowest;
}

std::vector<std::size_t> MistakeSearch::best_first() const {
  std::vector<std::size_t> order(hypotheses_.size());
  for (std::size_t h = 0; h < order.size(); ++h) order[h] = h;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return gain(a) > gain(b); });
  return order;
}

void MistakeSearch::refine_the_best() {
  std::vector<std::size_t> chosen;
  const auto order = best_first();
  if (order.empty()) return;
  const double least = std::max(0.0, worth_refining * gain(order.front()));
  for (const std::size_t h : order)
    if (hypotheses_[h].search != Search::none && chosen.size() < plan_.refined && gain(h) >= least) chosen.push_back(h);
  for_each_index(chosen.size(), processors(), [&](std::size_t c) { refine(chosen[c], plan_.most_steps); });
}

/// Walks uphill, twice as far after each success, and half as far, the other way, after each failure. A delay goes by
/// whole samples, and by parts of them where these leave something.
void MistakeSearch::refine(std::size_t h, int most_steps) {
  const Hypothesis& hypothesis = hypotheses_[h];
  if (hypothesis.search == Search::none) return;
  double steps = 1.0;
  for (int i = 0; i < most_steps; ++i) {
    const bool is_part = hypothesis.search == Search::samples && std::abs(steps) < 1.0;
    if (is_part && (scores_[h].leaves_nothing() || std::abs(steps) < finest_part)) break;
    const double before = scores_[h].log_likelihood;
    const bool better = try_value(h, moved(hypothesis, values_[h], steps)) > before;
    const bool first_failure = !better && i == 0;
    steps = better ? 2.0 * steps : first_failure ? -steps : -0.5 * steps;
  }
}

/// A hypothesis that only widens a sensor's noise explains where innovations are white and even by it.
bool MistakeSearch::explains(std::size_t h) const {
  return !hypotheses_[h].widens || (state_of(scores_[h].widening) == VerdictState::consistent &&
                                    state_of(scores_[h].loudest_part) == VerdictState::consistent);
}

/// Of those that explain as much as the best, the one that takes the fewest numbers from the record stands first. How
/// many there are.
std::size_t MistakeSearch::put_the_simplest_first() {
  const auto fits = [&](std::size_t h) { return std::isfinite(scores_[h].log_likelihood) && explains(h); };
  if (order_.empty() || !fits(order_.front())) return 0;
  const double tolerance = std::max(significant_rise, as_good * static_cast<double>(given_.samples.sum()));
  const double least = gain(order_.front()) - tolerance;
  const auto end = std::ranges::find_if(order_, [&](std::size_t h) { return !fits(h) || gain(h) < least; });
  std::stable_sort(order_.begin(), end,
                   [&](std::size_t a, std::size_t b) { return hypotheses_[a].fitted < hypotheses_[b].fitted; });
  return static_cast<std::size_t>(end - order_.begin());
}

/// The innovations of a hypothesis as an estimation would have them.
void MistakeSearch::settle(std::size_t h) {
  if (scores_[h].failed() || scores_[h].leaves_nothing()) return;
  const Undo undo = undoing(h);
  const DiagnosisInput undone = std::isfinite(input_.steps) ? undo(input_).input : found_again(input_, undo);
  scores_[h] = after_more_passes(std::move(scores_[h]), undone.run(), options_);
}

void MistakeSearch::collect(Diagnosis& diagnosis) {
  order_ = best_first();
  std::ranges::stable_partition(order_, [&](std::size_t h) { return explains(h); });
  const std::size_t as_likely = put_the_simplest_first();
  if (!order_.empty()) settle(order_.front());
  for (const std::size_t h : order_) {
    const auto& hypothesis = hypotheses_[h];
    const auto& score = scores_[h];
    const bool failed = !std::isfinite(score.log_likelihood);
    diagnosis.tested.push_back({.code = hypothesis.code,
                                .subject = hypothesis.subject,
                                .words = failed ? "" : hypothesis.words(values_[h], score.estimates),
                                .remedy = hypothesis.remedy,
                                .value = values_[h],
                                .turned = hypothesis.turned,
                                .forces = failed || !hypothesis.forces ? std::vector<LackingForce>{}
                                                                       : hypothesis.forces(values_[h], score.estimates),
                                .fitted = hypothesis.fitted,
                                .failed = failed,
                                .explains = !failed && explains(h),
                                .gain = failed ? 0.0 : gain(h),
                                .mean_nis = score.mean_nis,
                                .expected_nis = score.expected_nis,
                                .nis_before = given_.mean_nis,
                                .widening = score.widening});
  }
  const auto& tested = diagnosis.tested;
  for (std::size_t i = 1; i < as_likely; ++i)
    if (tested[i].fitted == tested.front().fitted) diagnosis.also.push_back(tested[i].words);
}

}  // namespace kalfem
