// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/estimation/unknowns_history.hpp"

namespace kalfem {

/// A change that the scores of a run hint at.
struct ChangeHint {
  Eigen::Index unknown = 0;  ///< its place among all unknowns
  Eigen::Index sample = 0;
  double statistic = 0.0;  ///< Lagrange multiplier statistic of a change there, see find_parameter_jump()
};

/// The largest statistic of each constant unknown, the largest first; by chance above 16 in about 1 of 500 records
/// (Andrews 1993, Table 1, continued). Empty without a history.
std::vector<ChangeHint> change_hints(const UnknownsHistory& history, Eigen::Index first);

}  // namespace kalfem
