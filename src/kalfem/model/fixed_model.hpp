// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// One model whatever the parameters, of which it has none.
class FixedModel final : public ParameterisedModel {
public:
  explicit FixedModel(LinearModel model) : model_(std::move(model)) {}
  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& /*none*/) const override { return {model_, {}}; }
  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& /*none*/) const override { return {}; }

private:
  LinearModel model_;
};

}  // namespace kalfem
