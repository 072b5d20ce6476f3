// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/evidence.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// In parts of the priors' deviations H is I + (J S)^T (J S), S = diag(sigma), and its determinant holds the sum of
// logarithms.
double log_evidence(const std::vector<UpdatingParameter>& parameters, const VectorXd& theta,
                    const ResidualValue& value) {
  VectorXd sigma(theta.size()), moved(theta.size());
  for (Index i = 0; i < theta.size(); ++i) {
    const auto& parameter = parameters[static_cast<std::size_t>(i)];
    sigma[i] = parameter.deviation;
    moved[i] = (theta[i] - parameter.initial) / parameter.deviation;
  }
  const MatrixXd scaled = value.jacobian * sigma.asDiagonal();
  const MatrixXd factor =
      MatrixXd(MatrixXd::Identity(theta.size(), theta.size()) + scaled.transpose() * scaled).llt().matrixL();
  return -0.5 * (value.values.squaredNorm() + moved.squaredNorm()) - factor.diagonal().array().log().sum();
}

}  // namespace kalfem
