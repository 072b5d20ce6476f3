// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/considered.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<Index> free_parameters(const ParameterStatistics& statistics) {
  std::vector<Index> free;
  for (Index i = 0; i < statistics.deviations.size(); ++i)
    if (std::isfinite(statistics.deviations[i])) free.push_back(i);
  return free;
}

/// -H^-1 J^T C of the free parameters, in their scales.
MatrixXd shifts_of(const std::vector<UpdatingParameter>& parameters, const std::vector<Index>& free,
                   const MatrixXd& jacobian, const MatrixXd& by_numbers) {
  const auto count = static_cast<Index>(free.size());
  VectorXd scale(count), prior(count);
  for (Index k = 0; k < count; ++k) {
    const auto& parameter = parameters[static_cast<std::size_t>(free[static_cast<std::size_t>(k)])];
    scale[k] = parameter.scale();
    prior[k] = parameter.scale() / parameter.deviation;
  }
  const MatrixXd scaled = jacobian(Eigen::all, free) * scale.asDiagonal();
  MatrixXd both(scaled.rows() + count, count), right = MatrixXd::Zero(both.rows(), by_numbers.cols());
  both << scaled, MatrixXd(prior.asDiagonal());
  right.topRows(by_numbers.rows()) = by_numbers;
  return -(scale.asDiagonal() * both.colPivHouseholderQr().solve(right));
}

}  // namespace

Considered consider(const std::vector<UpdatingParameter>& parameters, const ParameterStatistics& statistics,
                    const ResidualValue& value, const MatrixXd& by_numbers, const VectorXd& sigma) {
  const std::vector<Index> free = free_parameters(statistics);
  Considered found;
  found.shift = MatrixXd::Zero(std::ssize(parameters), by_numbers.cols());
  if (!free.empty()) found.shift(free, Eigen::all) = shifts_of(parameters, free, value.jacobian, by_numbers);
  found.by_number = found.shift.cwiseAbs() * sigma.asDiagonal();
  found.deviations = found.by_number.rowwise().norm();
  const MatrixXd followed = (by_numbers + value.jacobian * found.shift) * sigma.asDiagonal();
  const MatrixXd precision = followed.transpose() * followed + MatrixXd::Identity(sigma.size(), sigma.size());
  const VectorXd changes = -precision.ldlt().solve(followed.transpose() * value.values);
  found.allowed = sigma.cwiseProduct(changes);
  found.residual = value.values + followed * changes;
  return found;
}

}  // namespace kalfem
