// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/unscented_transform.hpp"

#include "kalfem/estimation/kernels/small_kernels.hpp"
#include "kalfem/estimation/partially_linear/argument_factor.hpp"

namespace kalfem {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void multiply_factor(const MatrixXd& a, const MatrixXd& factor, FactorShape shape, MatrixXd& out) {
  if (shape == FactorShape::lower_triangular)
    multiply_lower(a, factor, out);
  else
    multiply(a, factor, out);
}

}  // namespace

UnscentedTransform UnscentedTransform::linearised() {
  UnscentedTransform transform;
  transform.arguments_ = ArgumentTransform::linearised();
  return transform;
}

bool UnscentedTransform::apply(PartiallyLinearMap& map, const VectorXd& mean, const MatrixXd& factor,
                               FactorShape shape) {
  const bool of_arguments = arguments_.options().points == SigmaPoints::of_arguments;
  multiply_factor(map.selection(), factor, shape, selected_);
  if (of_arguments) {
    multiply_transposed(selected_, selected_, argument_covariance_);
    if (!argument_factor(argument_covariance_, argument_factor_)) return false;
  }
  centre_ = map.input_offset();
  centre_.noalias() += map.selection() * mean;
  if (!arguments_.apply(map, centre_, of_arguments ? argument_factor_ : selected_)) return false;

  mean_ = map.offset();
  mean_.noalias() += map.linear() * mean;
  mean_.noalias() += map.gain().lazyProduct(arguments_.mean());
  multiply_factor(map.linear(), factor, shape, deviations_);
  if (of_arguments) {
    solve_arguments(argument_factor_, selected_);
    argument_delta_.noalias() = selected_.transpose() * arguments_.delta();
  }
  add_product_transposed(map.gain(), of_arguments ? argument_delta_ : arguments_.delta(), deviations_);
  return true;
}

bool UnscentedTransform::apply_about(PartiallyLinearMap& map, const VectorXd& mean, const MatrixXd& factor,
                                     const VectorXd& u, const MatrixXd& T) {
  there_ = mean;
  there_.noalias() += factor.triangularView<Eigen::Lower>() * u;
  multiply_lower(factor, T, factor_there_);
  if (!apply(map, there_, factor_there_, FactorShape::lower_triangular)) return false;
  T.triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(deviations_);
  mean_.noalias() -= deviations_ * u;
  return true;
}

void UnscentedTransform::add_covariance(const PartiallyLinearMap& map, MatrixXd& covariance) {
  gain_scatter_.noalias() = map.gain().lazyProduct(arguments_.scatter());
  add_symmetric_product(deviations_, deviations_, covariance);
  add_symmetric_product(gain_scatter_, map.gain(), covariance);
}

}  // namespace kalfem
