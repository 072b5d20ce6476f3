// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/evidence.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of a linear residual r = r_0 + J (theta - theta_0) the integral over the priors is known:
//     Z = det(I + J S^2 J^T)^(-1/2) exp(-r_0^T (I + J S^2 J^T)^-1 r_0 / 2).
TEST(Evidence, OfALinearResidualIsExact) {
  const MatrixXd jacobian{{2.0, -1.0}, {0.5, 3.0}, {1.0, 1.0}};
  const VectorXd first{{1.5, -0.7, 2.0}}, sigma{{0.3, 1.2}}, start{{4.0, -2.0}};
  const MatrixXd spread = jacobian * sigma.cwiseAbs2().asDiagonal() * jacobian.transpose() + MatrixXd::Identity(3, 3);
  const double exact = -0.5 * std::log(spread.determinant()) - 0.5 * first.dot(spread.inverse() * first);

  const MatrixXd precision = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  const VectorXd moved = -(jacobian.transpose() * jacobian + precision).inverse() * jacobian.transpose() * first;
  const std::vector<UpdatingParameter> parameters{{.name = "a", .initial = start[0], .deviation = sigma[0]},
                                                  {.name = "b", .initial = start[1], .deviation = sigma[1]}};
  EXPECT_NEAR(log_evidence(parameters, start + moved, {first + jacobian * moved, jacobian}), exact, 1e-13);
}

}  // namespace
}  // namespace kalfem
