// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// A residual written as a function in a test.
class FunctionResidual final : public Residual {
public:
  using Function = std::function<std::optional<ResidualValue>(const Eigen::VectorXd& parameters)>;

  FunctionResidual(Eigen::Index size, Function function) : size_(size), function_(std::move(function)) {}

  [[nodiscard]] std::string name() const override { return "function"; }
  [[nodiscard]] Eigen::Index size() const override { return size_; }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override {
    auto value = function_(parameters);
    if (value && !with_jacobian) value->jacobian.resize(0, 0);
    return value;
  }

private:
  Eigen::Index size_;
  Function function_;
};

/// r = A theta - b.
inline FunctionResidual linear_residual(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return {right.size(), [=](const Eigen::VectorXd& theta) { return ResidualValue{matrix * theta - right, matrix}; }};
}

/// Rosenbrock's valley, r = [10 (y - x^2); 1 - x]; its minimum is at (1, 1).
inline FunctionResidual rosenbrock() {
  return {2, [](const Eigen::VectorXd& theta) {
            ResidualValue value{Eigen::VectorXd(2), Eigen::MatrixXd(2, 2)};
            value.values << 10.0 * (theta[1] - theta[0] * theta[0]), 1.0 - theta[0];
            value.jacobian << -20.0 * theta[0], 10.0, -1.0, 0.0;
            return value;
          }};
}

/// Parameters p1, p2, ... that begin at `start`, without bounds or prior.
inline std::vector<UpdatingParameter> free_parameters(const Eigen::VectorXd& start) {
  std::vector<UpdatingParameter> parameters;
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    parameters.emplace_back();
    parameters.back().name = "p" + std::to_string(i + 1);
    parameters.back().initial = start[i];
  }
  return parameters;
}

}  // namespace kalfem
