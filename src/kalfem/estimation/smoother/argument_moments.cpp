// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/argument_moments.hpp"

#include "kalfem/estimation/partially_linear/argument_factor.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool ArgumentMoments::evaluate(PartiallyLinearMap& map, const VectorXd& centre, const MatrixXd& covariance) {
  const Index q = centre.size(), p = map.gain().cols();
  if (map.moving_gain() == 0 && map.gain().isZero(0.0)) {
    mean_.setZero(p);
    slopes_.setZero(q, p);
    phi_variance_.setZero(p, p);
    return true;
  }
  covariance_ = covariance;  // a difference of covariances may leave a variance just below zero
  covariance_.diagonal() = covariance.diagonal().cwiseMax(0.0);
  if (!independent_argument_factor(covariance_, Dependent::raised, factor_, independent_)) return false;
  const auto directions = static_cast<Index>(independent_.size());
  if (!transform_.apply(map, centre, factor_.topLeftCorner(q, directions), q)) return false;
  mean_ = transform_.mean();
  solve_independent_transposed(factor_, independent_, transform_.delta(), slopes_transposed_);
  slopes_ = slopes_transposed_.topRows(p).transpose();
  phi_variance_ = transform_.scatter() + transform_.delta().transpose() * transform_.delta();
  return slopes_.allFinite();
}

}  // namespace kalfem
