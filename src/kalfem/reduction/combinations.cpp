// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/combinations.hpp"

namespace kalfem {

using Eigen::Index;

CombinationRows::CombinationRows(const LinearModel& model) {
  for (const auto* combinations : {&model.points, &model.gauges})
    for (const auto& [name, combination] : *combinations)
      for (const auto& [dof, coefficient] : combination) places_.emplace(dof, -1);
  if (places_.empty()) return;
  for (Index i = 0; i < model.size(); ++i)
    if (const auto found = places_.find(model.dofs[static_cast<std::size_t>(i)]); found != places_.end())
      found->second = i;
}

Eigen::RowVectorXd CombinationRows::value(const DofCombination& combination, const Eigen::MatrixXd& X) const {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(X.cols());
  for (const auto& [dof, coefficient] : combination) sum += coefficient * X.row(places_.at(dof));
  return sum;
}

}  // namespace kalfem
