// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// Derivatives of a smooth vector function by differences whose error is of order step^2, N x p: central where the
/// bounds leave room on both sides, and otherwise (-3 r(0) + 4 r(h) - r(2 h)) / (2 h) towards the side with more room;
/// r(-h) beyond a bound may not exist. h_i = relative_step scale_i, shorter where the bounds are closer. Zero for
/// a parameter with equal bounds. Two calls per parameter, in several threads. Nothing where a call gives nothing.
/// `values`: r at `point`. `residual(point)` -> std::optional<Eigen::VectorXd>.
template <class Function>
std::optional<Eigen::MatrixXd> difference_jacobian(const std::vector<UpdatingParameter>& parameters,
                                                   const Eigen::VectorXd& point, const Eigen::VectorXd& values,
                                                   double relative_step, int threads, const Function& residual) {
  const auto column = [&](Eigen::Index i) -> std::optional<Eigen::VectorXd> {
    const auto& parameter = parameters[static_cast<std::size_t>(i)];
    const double below = point[i] - parameter.lower, above = parameter.upper - point[i];
    if (!(parameter.lower < parameter.upper)) return Eigen::VectorXd::Zero(values.size()).eval();
    const auto at = [&](double change) {
      Eigen::VectorXd beside = point;
      beside[i] += change;
      return residual(beside);
    };
    const double wanted = relative_step * parameter.scale();
    if (wanted <= below && wanted <= above) {
      const auto left = at(-wanted), right = at(wanted);
      if (!left || !right) return std::nullopt;
      return ((*right - *left) / (2.0 * wanted)).eval();
    }
    const double step = std::min(wanted, 0.5 * std::max(below, above)), inwards = above >= below ? step : -step;
    const auto near = at(inwards), far = at(2.0 * inwards);
    if (!near || !far) return std::nullopt;
    return ((-3.0 * values + 4.0 * *near - *far) / (2.0 * inwards)).eval();
  };
  return parallel_columns(values.size(), point.size(), threads, column);
}

}  // namespace kalfem
