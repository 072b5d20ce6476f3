// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/diagnosis/mistake_search.hpp"

namespace kalfem {

namespace {

constexpr std::size_t most_starts = 3;  ///< mistakes beside which a second one is looked for
constexpr int rounds_of_pair = 2;       ///< in which one is found again beside the other

template <class Mistake, class Other>
bool is_same(const Mistake& one, const Other& other) {
  return one.code == other.code && one.subject == other.subject;
}

/// Whether what a mistake leaves is much less than what was there before it was undone.
bool explains(const TestedHypothesis& mistake, const Diagnosis& before) {
  const double excess = std::abs(before.mean_nis - before.expected_nis);
  const double left = std::abs(mistake.mean_nis - mistake.expected_nis);
  if (before.failed) return mistake.widening < unusable_widening;
  return left < 0.7 * excess || mistake.widening < 0.8 * before.widening;
}

bool leaves_less(const TestedHypothesis& one, const TestedHypothesis& other) {
  return !one.failed && std::abs(one.mean_nis - one.expected_nis) < std::abs(other.mean_nis - other.expected_nis);
}

/// A mistake, and how it is undone with the number that was found.
struct Found {
  TestedHypothesis mistake;
  Undo undo;

  [[nodiscard]] bool leaves_nothing() const { return state_of(mistake.widening) == VerdictState::consistent; }
};

/// What is left with a mistake undone, and the search for another one in it.
struct SearchBeside {
  SearchBeside(const DiagnosisInput& whole, const Found& other, const TrialPlan& plan)
      : search(found_again(whole, other.undo), plan) {}

  void run(const std::function<bool(const Hypothesis&)>& wanted) { diagnosis = search.run(wanted); }
  [[nodiscard]] Found likeliest() const { return {diagnosis.tested.front(), search.undo(0)}; }
  [[nodiscard]] double mean_nis() const {
    return diagnosis.failed ? std::numeric_limits<double>::infinity() : diagnosis.mean_nis;
  }

  MistakeSearch search;
  Diagnosis diagnosis;
};

/// One of the likeliest mistakes, and what is left with it undone.
struct Start {
  Found found;
  SearchBeside beside;
};

/// Two mistakes at once.
struct Pair {
  std::vector<TestedHypothesis> mistakes;
  double gain = -std::numeric_limits<double>::infinity();  ///< of both together
  bool leaves_nothing = false;                             ///< to explain
};

/// With one mistake undone another one is looked for. Then each is looked for again beside the other, as their numbers
/// may hold a part of each other, and kept where it leaves less. Nothing where one of them is not needed.
std::optional<Pair> pair_with(const DiagnosisInput& whole, Start& start, const TrialPlan& plan) {
  Found one = start.found;
  start.beside.run([&](const auto& each) { return !is_same(one.mistake, each); });
  if (!start.beside.diagnosis.cause()) return std::nullopt;
  Found other = start.beside.likeliest();
  const double gain = one.mistake.gain + other.mistake.gain;
  for (int round = 0; round < rounds_of_pair; ++round) {
    SearchBeside again(whole, other, plan);
    again.run([&](const auto& each) { return is_same(one.mistake, each); });
    one.mistake.nis_before = again.mean_nis();
    if (!explains(other.mistake, again.diagnosis)) return std::nullopt;
    if (again.diagnosis.tested.empty() || !leaves_less(again.likeliest().mistake, other.mistake)) break;
    one = std::exchange(other, again.likeliest());
    if (other.leaves_nothing()) break;
  }
  one.mistake.mean_nis = other.mistake.mean_nis;  // with the other's last number
  one.mistake.widening = other.mistake.widening;
  Pair pair{{one.mistake, other.mistake}, gain, other.leaves_nothing()};
  if (pair.mistakes[1].gain > pair.mistakes[0].gain) std::swap(pair.mistakes[0], pair.mistakes[1]);
  return pair;
}

/// The likeliest mistake of each subject, the best first. One that takes fewer numbers from the record stands for those
/// of its subject that explain little more: a unit that is wrong by a thousand for a gain of .00086. None is the noise
/// of a sensor, which takes any other mistake for itself.
std::vector<std::size_t> starts(const std::vector<TestedHypothesis>& tested) {
  constexpr double little_more = 0.9;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < tested.size(); ++i) {
    const auto& each = tested[i];
    if (each.failed || !(each.gain > significant_rise) || each.code == "sensor_noise") continue;
    const auto same = std::ranges::find(chosen, each.subject, [&](std::size_t c) { return tested[c].subject; });
    if (same == chosen.end())
      chosen.push_back(i);
    else if (each.fitted < tested[*same].fitted && each.gain > little_more * tested[*same].gain)
      *same = i;
  }
  if (chosen.size() > most_starts) chosen.resize(most_starts);
  return chosen;
}

/// The likeliest pair, if it is far likelier than the best single mistake.
std::vector<TestedHypothesis> best_pair(const DiagnosisInput& whole, std::vector<Start>& starts,
                                        const Diagnosis& single, const TrialPlan& plan) {
  Pair best;
  for (auto& start : starts) {
    if (auto pair = pair_with(whole, start, plan); pair && pair->gain > best.gain) best = std::move(*pair);
    if (best.leaves_nothing) break;
  }
  const auto alone = single.cause();
  return best.gain > (alone ? alone->gain : 0.0) + significant_rise ? best.mistakes : std::vector<TestedHypothesis>{};
}

/// Puts the i-th mistake before all others, with what is left where nothing else is wrong.
void take_for_cause(std::size_t i, const TrialScore& left, Diagnosis& diagnosis) {
  auto& tested = diagnosis.tested;
  std::rotate(tested.begin(), tested.begin() + static_cast<std::ptrdiff_t>(i),
              tested.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  tested.front().mean_nis = left.mean_nis;
  tested.front().widening = left.widening;
  diagnosis.also.clear();
}

/// Where the likeliest mistake leaves something: whether one of the likeliest leaves nothing with the unknown gains,
/// clocks and noise found again, or else which two mistakes there are.
void look_further(const MistakeSearch& search, const TrialPlan& plan, Diagnosis& diagnosis) {
  std::vector<Start> likeliest;
  for (const std::size_t i : starts(diagnosis.tested)) {
    const Found found{diagnosis.tested[i], search.undo(i)};
    likeliest.push_back({found, {search.input(), found, plan}});
    if (likeliest.back().beside.search.given().leaves_nothing())
      return take_for_cause(i, likeliest.back().beside.search.given(), diagnosis);
  }
  diagnosis.together = best_pair(search.input(), likeliest, diagnosis, plan);
}

/// "; as likely: ..., or ..."
std::string as_likely(const Diagnosis& diagnosis) {
  std::string others;
  for (const auto& words : diagnosis.also) others += (others.empty() ? "; as likely: " : ", or ") + words;
  return others;
}

std::string remainder(bool all_is_explained) { return all_is_explained ? "" : ", which does not explain all"; }

std::string text_of_single(const Diagnosis& diagnosis, const TestedHypothesis& cause) {
  const std::string before = diagnosis.failed ? "the filter stopped" : fmt::format("it is {:.3g}", diagnosis.mean_nis);
  return fmt::format("{}: with this undone the mean NIS is {:.3g} (expected {:.3g}), as given {}{}{}", cause.words,
                     cause.mean_nis, cause.expected_nis, before, remainder(diagnosis.one_explains_all()),
                     as_likely(diagnosis));
}

std::string text_beside(const TestedHypothesis& one, const TestedHypothesis& other, bool all_is_explained) {
  const std::string alone =
      std::isfinite(one.nis_before) ? fmt::format("it is {:.3g}", one.nis_before) : "the filter stops";
  const std::string second =
      one.subject == other.subject ? other.words : fmt::format("'{}' is not as it should be either", other.subject);
  return fmt::format(
      "{}, and {}: with both undone the mean NIS is {:.3g} (expected {:.3g}){}, with the other one alone {}", one.words,
      second, one.mean_nis, one.expected_nis, remainder(all_is_explained), alone);
}

}  // namespace

std::optional<TestedHypothesis> Diagnosis::cause() const {
  if (tested.empty() || tested.front().failed || !tested.front().explains || !(tested.front().gain > significant_rise))
    return std::nullopt;
  return kalfem::explains(tested.front(), *this) ? std::optional(tested.front()) : std::nullopt;
}

bool Diagnosis::one_explains_all() const {
  const auto single = cause();
  return single && state_of(single->widening) == VerdictState::consistent;
}

bool Diagnosis::explains_all() const {
  return together.empty() ? one_explains_all() : state_of(together.back().widening) == VerdictState::consistent;
}

std::vector<TestedHypothesis> Diagnosis::causes() const {
  if (!together.empty()) return together;
  const auto single = cause();
  return single ? std::vector{*single} : std::vector<TestedHypothesis>{};
}

std::optional<Diagnosis> diagnose(const DiagnosisInput& input) {
  const Stopwatch watch;
  const auto plan = plan_for(input, input.run());
  if (!plan) return std::nullopt;
  MistakeSearch search(input, *plan);
  Diagnosis diagnosis = search.run();
  if (!std::isfinite(input.steps) && !diagnosis.one_explains_all())
    look_further(search, plan_of_next(*plan), diagnosis);
  diagnosis.seconds = watch.seconds();
  return diagnosis;
}

std::vector<Reason> reasons_of(const Diagnosis& diagnosis, VerdictState state) {
  const auto causes = diagnosis.causes();
  std::vector<Reason> reasons;
  for (std::size_t i = 0; i < causes.size(); ++i)
    reasons.push_back({.code = causes[i].code,
                       .subject = causes[i].subject,
                       .text = causes.size() == 1 ? text_of_single(diagnosis, causes[i])
                                                  : text_beside(causes[i], causes[1 - i], diagnosis.explains_all()),
                       .remedy = causes[i].remedy,
                       .state = state,
                       .weight = std::numeric_limits<double>::infinity()});
  return reasons;
}

}  // namespace kalfem
