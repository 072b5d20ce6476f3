// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/records/record.hpp"

namespace kalfem {

/// How late one acquisition system is behind another.
struct CommonDelay {
  double delay = 0.0;        ///< late(t) = factor reference(t - delay), by the clocks of the two files [s]
  double correlation = 0.0;  ///< of the two there, -1 to 1; negative: they look in opposite directions
};

/// Delay between two records of one channel that measured the same, each at its own rate and by its own clock: where
/// their cross-correlation is largest, normalised by what overlaps (a quarter of the shorter record or more). Fractions
/// of a sample count: the correlation of band-limited signals is known between its samples. Means do not matter,
/// missing samples count as means. Throws InvalidInput where a record has fewer than 16 samples.
CommonDelay common_delay(const Record& reference, const Record& late);

}  // namespace kalfem
