// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimation.hpp"

namespace kalfem {

/// Where an estimation contradicts itself with the numbers that it holds fixed, and some of them are known to a
/// deviation only, these numbers c are moved to where the record, and what is stated of them, have them:
///
/// the maximum over c of ln L(c) - c^T S^-1 c / 2, S the stated variances, the unknowns estimated at each c, by
/// Gauss-Newton, c <- (I + S^-1)^-1 (g + I c), with the score g and the information I of study_fixed_numbers(), the
/// step halved where the maximum is not approached. The first runs take what wrong numbers do for noise of the sensors:
/// such a filter is not misled by them.
///
/// The estimation is replaced by the one there if that one no longer contradicts itself; otherwise the stated numbers
/// are not what is wrong, and it stays.
void move_within_stated(RecordEstimation& estimation);

}  // namespace kalfem
