// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/reported_quantities.hpp"

#include <cmath>

#include "kalfem/records/record.hpp"
#include "kalfem/study/component_parts.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {

namespace {

constexpr ObservedQuantity point_quantities[] = {ObservedQuantity::displacement, ObservedQuantity::velocity,
                                                 ObservedQuantity::acceleration};
constexpr ObservedQuantity connector_quantities[] = {
    ObservedQuantity::connector_deformation, ObservedQuantity::connector_rate, ObservedQuantity::connector_force};

}  // namespace

std::vector<OutputDescription> reported_quantities(const CoupledModel& model) {
  std::vector<OutputDescription> outputs;
  const auto carries_signal = [](const Connector& connector) { return connector.law->name() == signal_law_name; };
  const auto is_signal_ground = [](const std::string& point) { return point.starts_with(signal_grounds + "."); };
  for (const auto& point : model.reported_points())
    if (!is_signal_ground(point))
      for (const auto quantity : point_quantities) outputs.push_back({point, quantity, {{point, 1.0}}, false});
  for (const auto& connector : model.system().connectors)
    if (!carries_signal(connector))
      for (const auto quantity : connector_quantities)
        outputs.push_back({connector.name, quantity, {{connector.name, 1.0}}, false});
  for (const auto& gauge : model.gauges()) outputs.push_back({gauge, ObservedQuantity::strain, {{gauge, 1.0}}, false});
  return outputs;
}

const PointQuantity* find_quantity(const std::vector<PointQuantity>& quantities, const std::string& point,
                                   ObservedQuantity quantity) {
  for (const auto& each : quantities)
    if (each.point == point && each.quantity == quantity) return &each;
  return nullptr;
}

void TruthComparison::compare(PointQuantity& quantity, const Eigen::VectorXd& truth) {
  quantity.truth = truth;
  const Eigen::Index count = truth.size() - settled_;
  if (count < 1 || truth.size() != quantity.mean.size()) return;
  const Eigen::VectorXd mean = quantity.mean.tail(count), expected = truth.tail(count);
  if (const double error = nrmse(mean, expected); std::isfinite(error)) quantity.nrmse = error;
  const bool strain = quantity.quantity == ObservedQuantity::strain;
  if (strain && quantity.deviation.size() == truth.size()) {
    const Eigen::ArrayXd half_width = 1.96 * quantity.deviation.tail(count).array();
    quantity.coverage = ((mean - expected).array().abs() <= half_width).cast<double>().mean();
  }
  if (!band_ || count < 2 || (!strain && quantity.quantity != ObservedQuantity::acceleration)) return;
  const double error = error_in_band(mean, expected);
  if (std::isfinite(error)) quantity.nrmse_in_band = error;
}

double TruthComparison::error_in_band(const Eigen::VectorXd& mean, const Eigen::VectorXd& expected) {
  if (!in_band_ || samples_ != expected.size()) in_band_.emplace(expected.size(), sample_rate_, *band_);
  samples_ = expected.size();
  return (*in_band_)(mean, expected);
}

}  // namespace kalfem
