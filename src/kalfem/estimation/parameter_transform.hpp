// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// How an unknown parameter is carried in the filter's state, so that no sigma point leaves its range.
enum class TransformKind {
  none,  ///< p = x
  log,   ///< p = exp(x) > 0
  logit  ///< p = lower + (upper - lower) / (1 + exp(-x))
};

struct ParameterTransform {
  TransformKind kind = TransformKind::none;
  double lower = 0.0;  ///< of logit
  double upper = 1.0;  ///< of logit

  /// p from the state x.
  [[nodiscard]] double to_parameter(double state) const;
  void to_parameter(const Eigen::Ref<const Eigen::ArrayXd>& state, Eigen::Ref<Eigen::ArrayXd> parameter) const;
  /// x from p; p must lie inside the range.
  [[nodiscard]] double to_state(double parameter) const;
  /// |dp/dx| at x: standard deviations carry over to first order.
  [[nodiscard]] double slope(double state) const;
};

}  // namespace kalfem
