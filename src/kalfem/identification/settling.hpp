// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/record_start.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Time from a record's start before errors and consistency count [s]. It holds as it is stated. Otherwise nothing is
/// left out where the motion at the start is known: the filter is consistent from the first sample. Where it is not,
/// its prior is a guess of the record's size, whose share dies out with the structure's own motion: until the slowest
/// mode has decayed to 1 % of its amplitude, but no more than a tenth of the record.
double settling_time(const EstimationSettings& settings, const AugmentedModelSetup& setup, const RecordStart& start,
                     const Record& record);

/// The first sample that counts. Of a stated time that covers the whole record, the last one.
Eigen::Index first_settled_sample(const EstimationSettings& settings, const AugmentedModelSetup& setup,
                                  const RecordStart& start, const Record& record);

}  // namespace kalfem
