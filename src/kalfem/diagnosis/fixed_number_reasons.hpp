// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/fixed_number_study.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// By how many of its standard deviations, those of its 95 % interval, a change of number `i` by one scale moves the
/// unknown that it moves furthest.
struct FurthestShift {
  Eigen::Index unknown = 0;
  double deviations = 0.0;  ///< signed
};
FurthestShift furthest_shift(const RecordEstimate& estimate, Eigen::Index i);

/// The change of a number in words: "+0.98 % +- 0.06 %", of a delay "+0.2 ms +- 0.01 ms".
std::string change_in_words(const FixedNumber& number, double change, std::optional<double> deviation = {});

/// A number that is held fixed at a value against which the record speaks: the change that it asks for is significant
/// at .5 % over all numbers together, beyond what is stated of it; a run with the change confirms it; and it moves an
/// unknown by more than its deviation. The likeliest one is the reason `fixed_parameter`, and a cause. Where the
/// innovations contradict the model it must also explain that: with the change the mean NIS, by its linear prediction,
/// is about what is expected. Otherwise a larger mistake is looked for first.
std::vector<Reason> fixed_number_reasons(const RecordEstimate& estimate);

}  // namespace kalfem
