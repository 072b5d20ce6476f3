// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Where an unknown that walks went: its least and its greatest estimate after settling, and how far their 95 % band
/// reaches [unit of the unknown].
struct WalkedRange {
  double least = 0.0, greatest = 0.0;
  double lower = 0.0, upper = 0.0;
};

/// Nothing for an unknown without random walk.
std::optional<WalkedRange> walked_range(const RecordEstimate& estimate, Eigen::Index i);

}  // namespace kalfem
