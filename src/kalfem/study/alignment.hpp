// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/casefile/description.hpp"
#include "kalfem/records/common_delay.hpp"

namespace kalfem {

/// How late the clock of an input's file is behind that of the record, by the channel and the sensor of its `align`.
/// Throws InvalidInput where the case has no record or no such sensor, where one of the files lacks its column, and
/// where the two correlate by less than 0.5: they did not measure the same.
CommonDelay delay_behind_record(const description::Case& given, const description::FileSignal& input);

}  // namespace kalfem
