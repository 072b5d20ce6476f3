// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/identification/step_budget.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct RecordEstimate;

/// A number that was held fixed, tried as an unknown.
struct TriedNumber {
  std::string name;  ///< of the unknown: "s.2.mass", "sensors.a3.gain"
  FixedNumber number;
  double prior = 0.0;                   ///< its standard deviation as an unknown [its unit]
  double value = 0.0, deviation = 0.0;  ///< found; of a gain or clock from what is before the last third
  /// ln p(last third | before) with it as an unknown, less that with it held fixed.
  double predicted = 0.0;
  bool kept = false;
};

/// An estimate before and after numbers were freed.
struct MovedEstimate {
  std::string name, unit;
  double before = 0.0, after = 0.0;
  double deviations = 0.0;  ///< of the move, in those of the interval before
};

/// What became of the numbers that a record asks to change.
struct FreedNumbers {
  FreeNumbers how = FreeNumbers::ask;
  std::vector<TriedNumber> tried = {};
  std::vector<MovedEstimate> moved = {};   ///< by those kept
  EstimationProblemPtr problem = nullptr;  ///< with those kept as unknowns; null: none was kept
  bool taken = false;                      ///< the estimate is that with them

  [[nodiscard]] std::vector<TriedNumber> kept() const;
};

/// Whether a number can be an unknown: one of the structure, or a gain, delay or drift of a sensor.
bool can_be_freed(const FixedNumber& number);
/// "sensors.a3.gain" of "a3.gain"; otherwise its own name.
std::string name_as_unknown(const FixedNumber& number);

/// The problem with the number as an unknown more: about the value at which it was held, with that standard deviation
/// [its unit]. Throws InvalidInput where it cannot be one.
EstimationProblemPtr with_unknown(const EstimationProblem& problem, const FixedNumber& number, double prior);

/// Rise of ln p(last third | before) that says that a number is better estimated: under the model without it the ratio
/// of the two predictive densities has the mean 1, so that it exceeds 20 in at most one of twenty records (Markov).
/// What is tried was significant at .5 % before.
inline constexpr double fewest_predicted = 3.0;

/// Tries the numbers that the record asks to change (asked_numbers()) as unknowns, one after another, the likeliest
/// first, up to three of them. Each is a run of the filter over the record beside one as it was; both predict the last
/// third of it sample by sample from what is before. A gain, delay or drift is found by likelihood from the first two
/// thirds. The first that predicts better by fewest_predicted is kept. Nothing where the budget does not allow the
/// runs.
struct NumberTrials {
  std::vector<TriedNumber> tried;
  std::vector<MovedEstimate> moved;
  bool stopped = false;  ///< the budget did not allow one
};
NumberTrials try_numbers(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                         const RecordEstimate& estimate, StepBudget& budget);

/// The unknowns of an estimate beside those of another one by their names.
std::vector<MovedEstimate> moved_estimates(const RecordEstimate& before, const RecordEstimate& after);

}  // namespace kalfem
