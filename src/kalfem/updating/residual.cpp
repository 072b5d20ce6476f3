// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/residual.hpp"

#include <cmath>

namespace kalfem {

double UpdatingParameter::scale() const {
  if (initial != 0.0) return std::abs(initial);
  const double width = upper - lower;
  return std::isfinite(width) && width > 0.0 ? width : 1.0;
}

Eigen::VectorXd initial_values(const std::vector<UpdatingParameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) values[static_cast<Eigen::Index>(i)] = parameters[i].initial;
  return values;
}

using Eigen::Index;

RowLayout Residual::layout() const {
  RowLayout layout{.steps = "values"};
  for (Index row = 0; row < size(); ++row) layout.step.push_back(row);
  return layout;
}

std::optional<Eigen::MatrixXd> Residual::by_gains(const Eigen::VectorXd&) const { return Eigen::MatrixXd(size(), 0); }

RowLayout layout_of_series(Index samples, Index series) {
  RowLayout layout{.ordered = true, .steps = "samples", .parts = "sensors"};
  for (Index row = 0; row < samples * series; ++row) {
    layout.step.push_back(row % samples);
    layout.part.push_back(row / samples);
  }
  return layout;
}

Index ResidualSum::size() const {
  Index sum = 0;
  for (const auto& term : terms_) sum += term.residual->size();
  return sum;
}

std::optional<ResidualValue> ResidualSum::evaluate(const Eigen::VectorXd& parameters, bool with_jacobian) const {
  ResidualValue sum{Eigen::VectorXd(size()), {}};
  if (with_jacobian) sum.jacobian.resize(size(), parameters.size());
  Index first = 0;
  for (const auto& [residual, weight] : terms_) {
    const auto part = residual->evaluate(parameters, with_jacobian);
    if (!part) return std::nullopt;
    sum.values.segment(first, part->values.size()) = std::sqrt(weight) * part->values;
    if (with_jacobian) sum.jacobian.middleRows(first, part->values.size()) = std::sqrt(weight) * part->jacobian;
    first += part->values.size();
  }
  return sum;
}

}  // namespace kalfem
