// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kalfem {

enum class FilterKind {
  unscented,              ///< Table 1 of the paper, covariance form
  unscented_square_root,  ///< the same estimates, the covariance carried as a triangular factor
  partially_linear,       ///< sigma points of the few nonlinear arguments only, O(n^2) a step in modal coordinates
  partially_linear_square_root,  ///< the same estimates, the covariance carried as a triangular factor
  extended                       ///< first-order linearisation about the mean
};

/// As case files and summaries say it.
std::string to_string(FilterKind kind);

}  // namespace kalfem
