// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/excess.hpp"

#include "kalfem/linalg/scaled_inverse.hpp"

namespace kalfem {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

VectorXd deviation_of_excess(const Ref<const MatrixXd>& cross, const Ref<const MatrixXd>& covariance,
                             const Ref<const MatrixXd>& factor) {
  return (cross * (scaled_inverse(covariance) * factor)).rowwise().norm();
}

}  // namespace kalfem
