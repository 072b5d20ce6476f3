// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <unordered_map>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Finds the rows of those degrees of freedom that a model's points and gauges are combinations of.
class CombinationRows {
public:
  explicit CombinationRows(const LinearModel& model);

  /// sum_d c_d X_d of a combination c, 1 x k: its value in each column of X, n x k.
  [[nodiscard]] Eigen::RowVectorXd value(const DofCombination& combination, const Eigen::MatrixXd& X) const;

private:
  std::unordered_map<std::string, Eigen::Index> places_;
};

}  // namespace kalfem
