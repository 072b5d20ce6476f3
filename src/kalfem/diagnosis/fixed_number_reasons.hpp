// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/fixed_number_study.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The change of a number in words: "+0.98 % +- 0.06 %", of a delay "+0.2 ms +- 0.01 ms", of a drift "+50 ppm +- 2
/// ppm".
std::string change_in_words(const FixedNumber& number, double change, std::optional<double> deviation = {});

/// The likeliest of asked_numbers() is the reason `fixed_parameter`, and a cause. Where the
/// innovations contradict the model it must also explain that: with the change the mean NIS, by its linear prediction,
/// is about what is expected. Otherwise a larger mistake is looked for first.
std::vector<Reason> fixed_number_reasons(const RecordEstimate& estimate);

}  // namespace kalfem
