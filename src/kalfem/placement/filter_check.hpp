// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/placement/placement.hpp"

namespace kalfem {

/// Deviations of the counted unknowns after a run of the filter over the expected record of a set, in which noise is
/// stated but not added; empty where the filter fails.
Eigen::VectorXd deviation_by_filter(const PlacementProblem& problem, const std::vector<std::size_t>& set);

}  // namespace kalfem
