// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// S_k^-1/2 of every sample of a run, S_k the covariance of its innovations: with the right model the innovations times
/// it are independent and of variance one. Channels that the filter did not learn from are 0.
class WhiteInnovations {
public:
  explicit WhiteInnovations(const EstimationResult& result);

  /// The factor's product with values, channels x samples.
  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::MatrixXd& values) const;

private:
  Eigen::MatrixXi used_;                  ///< channels x samples
  std::vector<Eigen::MatrixXd> factors_;  ///< Cholesky factors of S_k
};

}  // namespace kalfem
