// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/statistics/robust_covariance.hpp"
#include "kalfem/updating/parameter_statistics.hpp"

namespace kalfem {

/// The rows of one comparison among those of a sum.
struct ResidualBlock {
  std::string name;
  Eigen::Index first = 0, size = 0;
  RowLayout layout;
};

/// Standard deviations of updated parameters that do not take the rows of the residual as independent.
struct RobustStatistics {
  Eigen::VectorXd deviations;       ///< not a number where there is none: held, at a bound, undetermined
  double degrees_of_freedom = 0.0;  ///< independent pieces that the scatter is taken from, less the parameters
  double bandwidth = 1.0;           ///< the largest of the comparisons with an order [steps]
  bool parts_count = false;         ///< the scatter between parts or comparisons is larger, and holds
  Eigen::Index parts = 0;           ///< parts and comparisons that were compared with each other
  Eigen::Index rank = 0;            ///< of the information of the free parameters
  double condition = 1.0;           ///< its largest over its smallest eigenvalue that counts
  std::string method;               ///< in words, with the source
  std::string none;                 ///< why there are none; empty if there are

  [[nodiscard]] bool exist() const { return none.empty(); }
};

/// The sandwich H^+ (B + P) H^+ with H and P of parameter_statistics() and B = Cov(J^T r) from the residuals
/// themselves, the sum over the comparisons, which count as independent:
///   ordered steps (samples, frequency lines): long_run_covariance() of the scores s_k = sum over the rows of step k
///     of J_i r_i, over sensors and responses together (Driscoll and Kraay 1998, Rev. Econ. Stat. 80, 549-560);
///   steps without order (modes, values): sum over the steps of s_k s_k^T with the adjustment CR2 for few of them
///     [BM02], which makes B unbiased where the rows are independent of equal variance:
///       s_k = J_k^T (I - J_k H^-1 J_k^T)^(-1/2) r_k.
/// Then the same CR2 sum over parts (sensors, inputs, comparisons) is held against it: where the variance of a
/// parameter from it is larger by more than chance gives once in a hundred times, it holds [CM15].
///
/// None where the steps are no more than the free parameters: nothing is left that scatters. With a true model they
/// are about those of parameter_statistics(). `value` holds the rows of all blocks.
RobustStatistics robust_statistics(const std::vector<UpdatingParameter>& parameters, const ResidualValue& value,
                                   const std::vector<ResidualBlock>& blocks, const ParameterStatistics& statistics);

}  // namespace kalfem
