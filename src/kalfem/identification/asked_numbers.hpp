// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/identification/fixed_number_study.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// By how many of its standard deviations, those of its 95 % interval, a change of number `i` by one scale moves the
/// unknown that it moves furthest.
struct FurthestShift {
  Eigen::Index unknown = 0;
  double deviations = 0.0;  ///< signed
};
FurthestShift furthest_shift(const RecordEstimate& estimate, Eigen::Index i);

/// Half the width of the 95 % interval of an unknown over 1.96 [its unit].
double interval_deviation(const RecordEstimate& estimate, Eigen::Index unknown);

/// Numbers of the estimate's study that are held fixed at values against which the record speaks, the likeliest first:
/// the change that it asks for is significant at .5 % over all numbers together, beyond what is stated of it, and a run
/// with the change confirms it. Nothing unless that of one of them moves an unknown by more than its deviation.
std::vector<Eigen::Index> asked_numbers(const RecordEstimate& estimate);

/// Whether the innovations agree with the model, or would with number `i` changed by little as the record asks: a large
/// change may stand for another mistake, such as a unit.
bool may_be_all_that_is_wrong(const RecordEstimate& estimate, Eigen::Index i);

/// Log-likelihood by which explanations are told apart.
inline constexpr double as_likely = 3.0;

}  // namespace kalfem
