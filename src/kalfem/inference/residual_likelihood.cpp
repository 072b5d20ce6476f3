// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/residual_likelihood.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ParameterLikelihood likelihood_of_residual(const std::shared_ptr<const ResidualSum>& residual,
                                           std::vector<std::string> names, std::string words, Index dofs) {
  constexpr double impossible = -std::numeric_limits<double>::infinity();
  const auto count = static_cast<double>(residual->size());
  const double normalisation = 0.5 * count * std::log(2.0 * std::numbers::pi);
  const double work = 2e5 + (5e4 + 100.0 * count) * static_cast<double>(dofs);
  return {std::move(names),
          [=](const VectorXd& theta) {
            const auto value = residual->evaluate(theta, false);
            return value ? -0.5 * value->values.squaredNorm() - normalisation : impossible;
          },
          [=](const VectorXd& theta) -> std::optional<MatrixXd> {
            const auto value = residual->evaluate(theta, true);
            if (!value) return std::nullopt;
            return MatrixXd(value->jacobian.transpose() * value->jacobian);
          },
          std::move(words), work};
}

}  // namespace kalfem
