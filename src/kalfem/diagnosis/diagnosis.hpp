// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kalfem {

/// A force that a connector lacks beside its law: K g(x, v; s) between the same points, g as in the law `expression`.
struct LackingForce {
  std::string name;  ///< of a connector that has it: "suspension_cubic_stiffness"
  std::string from, to;
  std::string force;                                        ///< "K*x^3"
  std::vector<std::pair<std::string, std::string>> states;  ///< of the force, each with its rate
  double factor = 0.0, deviation = 0.0;                     ///< K as it was found, and the width of its prior [SI]
  std::optional<double> place;                              ///< s, where the force has one [SI]
};

/// Rise of the log-likelihood that a mistake must bring.
constexpr double significant_rise = 20.0;

/// A mistake that was undone, and how well the record fits then.
struct TestedHypothesis {
  std::string code, subject;
  std::string words;  ///< the mistake, with the numbers that fit best
  std::string remedy;
  double value = 0.0;   ///< its number: a factor, a delay in samples, an offset
  bool turned = false;  ///< the channel's sign is wrong besides
  std::vector<LackingForce> forces = {};
  int fitted = 0;
  bool failed = false;   ///< whether the corrected filter stopped
  bool explains = true;  ///< false: it only widens noise, and innovations are not white and even by it
  /// By how much the log-likelihood rises, less (fitted / 2) log N for its numbers (Schwarz 1978, Ann. Stat. 6,
  /// 461-464).
  double gain = 0.0;
  double mean_nis = 0.0, expected_nis = 0.0;  ///< afterwards
  /// Mean NIS as given, or with the mistake undone that is beside it; infinite: the filter stopped.
  double nis_before = 0.0;
  double widening = 1.0;  ///< of the worst sensor afterwards, see SensorConsistency
};

/// Which mistake, or which two, explain a run that contradicts itself.
struct Diagnosis {
  double duration = 0.0;  ///< of the part of the record that was used, from its start [s]
  bool failed = false;    ///< whether the filter stopped in that part as it was given
  double mean_nis = 0.0, expected_nis = 0.0, widening = 1.0;  ///< as it was given
  std::vector<TestedHypothesis> tested;                       ///< one at a time, best first
  std::vector<std::string> also;                              ///< others that explain as much as the best, in words
  /// Two mistakes at once, where one does not explain all, the one that explains more first.
  std::vector<TestedHypothesis> together = {};
  double seconds = 0.0;

  /// The best of those that were tested one at a time, if it explains the record far better than what was given.
  [[nodiscard]] std::optional<TestedHypothesis> cause() const;
  /// The two mistakes at once, or the single cause; empty: nothing explains the record far better.
  [[nodiscard]] std::vector<TestedHypothesis> causes() const;
  /// Whether innovations are white and of their size with the single cause undone.
  [[nodiscard]] bool one_explains_all() const;
  /// The same of all causes.
  [[nodiscard]] bool explains_all() const;
};

}  // namespace kalfem
