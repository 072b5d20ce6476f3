// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/api/update.hpp"

namespace kalfem::test {

/// Intervals of updated stiffnesses, and those that hold the true one.
struct UpdatingTally {
  int records = 0, intervals = 0, held = 0;
  int consistent = 0;        ///< updates by their verdict
  double largest_std = 0.0;  ///< of a stiffness, relative to it
  double mean_square = 0.0;  ///< of errors over their deviations: 1 where these are right
};

/// A frame of four storeys whose stiffnesses are drawn within 25 % of those of the model: 20 minutes of its velocities
/// under white forces on the floors with noise of 5 %, damping 1 %, modes between 1 and 7 Hz. identify_modes() finds
/// its modes, and update() the four stiffnesses from their frequencies and shapes with the deviations and covariances
/// that they bring. One record for each seed.
UpdatingTally update_from_records(int first, int count);

}  // namespace kalfem::test
