// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/parameter_transform.hpp"

#include <cmath>

namespace kalfem {

double ParameterTransform::to_parameter(double state) const {
  switch (kind) {
    case TransformKind::none:
      return state;
    case TransformKind::log:
      return std::exp(state);
    case TransformKind::logit:
      return lower + (upper - lower) / (1.0 + std::exp(-state));
  }
  return state;
}

void ParameterTransform::to_parameter(const Eigen::Ref<const Eigen::ArrayXd>& state,
                                      Eigen::Ref<Eigen::ArrayXd> parameter) const {
  switch (kind) {
    case TransformKind::none:
      parameter = state;
      break;
    case TransformKind::log:
      parameter = state.exp();
      break;
    case TransformKind::logit:
      parameter = lower + (upper - lower) / (1.0 + (-state).exp());
      break;
  }
}

double ParameterTransform::to_state(double parameter) const {
  switch (kind) {
    case TransformKind::none:
      return parameter;
    case TransformKind::log:
      return std::log(parameter);
    case TransformKind::logit:
      return std::log((parameter - lower) / (upper - parameter));
  }
  return parameter;
}

double ParameterTransform::slope(double state) const {
  switch (kind) {
    case TransformKind::none:
      return 1.0;
    case TransformKind::log:
      return std::exp(state);
    case TransformKind::logit: {
      const double part = 1.0 / (1.0 + std::exp(-state));
      return (upper - lower) * part * (1.0 - part);
    }
  }
  return 1.0;
}

}  // namespace kalfem
