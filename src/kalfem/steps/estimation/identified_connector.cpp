// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/identified_connector.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd force_of(const ConnectorLaw& law, const VectorXd& parameters, const VectorXd& deformation,
                  const VectorXd& rate) {
  const Index n = deformation.size();
  const ArrayXXd p = parameters.transpose().array().replicate(n, 1), none = ArrayXXd::Zero(n, 0);
  const ArrayXd d = deformation.array(), v = rate.array(), zero = ArrayXd::Zero(n);
  ArrayXd f(n), k(n), c(n), b(n);
  ArrayXXd states(n, 0);
  law.respond({0.0, p, d, v, none, d, v, zero}, {f, k, c, b, states});
  return f.matrix();
}

bool has_unknown(const EstimationOutcome& outcome, Index connector) {
  return std::ranges::any_of(outcome.augmented_model->options().unknowns, [&](const auto& each) {
    return std::ranges::any_of(each.targets, [&](const auto& target) { return target.connector == connector; });
  });
}

const PointQuantity* connector_motion(const EstimationOutcome& outcome, const std::string& name,
                                      ObservedQuantity quantity) {
  const auto found =
      std::ranges::find_if(outcome.points, [&](const auto& p) { return p.point == name && p.quantity == quantity; });
  return found == outcome.points.end() ? nullptr : &*found;
}

IdentifiedConnector::IdentifiedConnector(const EstimationOutcome& outcome, Index connector)
    : outcome_(outcome), connector_(connector) {
  const auto& layout = outcome.augmented_model->layout();
  const Index last = outcome.result.state.mean.cols() - 1;
  state_ = outcome.result.state.mean.col(last).segment(layout.unknown(), layout.unknowns);
  covariance_ =
      outcome.result.final_covariance.block(layout.unknown(), layout.unknown(), layout.unknowns, layout.unknowns);
}

VectorXd IdentifiedConnector::parameters(const VectorXd& state) const {
  VectorXd values = outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].parameters;
  const auto& unknowns = outcome_.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      if (target.connector == connector_)
        values[target.parameter] = unknowns[i].transform.to_parameter(state[static_cast<Index>(i)]);
  return values;
}

Series IdentifiedConnector::curve(const VectorXd& deformation, const VectorXd& rate) const {
  const auto& law = *outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].law;
  const VectorXd mean = force_of(law, parameters(state_), deformation, rate);
  MatrixXd slope(mean.size(), state_.size());
  for (Index i = 0; i < state_.size(); ++i) {
    const double step = 1e-3 * std::sqrt(std::max(covariance_(i, i), 1e-300));
    VectorXd shifted = state_;
    shifted[i] += step;
    slope.col(i) = (force_of(law, parameters(shifted), deformation, rate) - mean) / step;
  }
  const VectorXd width =
      normal_quantile(0.975) * ((slope * covariance_).cwiseProduct(slope)).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
  return {.label = "identified, 95 %",
          .y = series_values(mean),
          .lower = series_values(mean - width),
          .upper = series_values(mean + width),
          .role = Role::estimate};
}

}  // namespace kalfem
