// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"

namespace kalfem {

/// Force of a law without memory at given deformations and rates.
Eigen::VectorXd force_of(const ConnectorLaw& law, const Eigen::VectorXd& parameters, const Eigen::VectorXd& deformation,
                         const Eigen::VectorXd& rate);

/// Whether the filter looks for a parameter of the connector.
bool has_unknown(const EstimationOutcome& outcome, Eigen::Index connector);

/// Deformation, rate or force of a connector over the record; null where it was not asked for.
const PointQuantity* connector_motion(const EstimationOutcome& outcome, const std::string& name,
                                      ObservedQuantity quantity);

/// Parameters of one connector in the augmented model as a function of the unknowns' states.
class IdentifiedConnector {
public:
  IdentifiedConnector(const EstimationOutcome& outcome, Eigen::Index connector);

  /// At the last estimate.
  [[nodiscard]] Eigen::VectorXd parameters() const { return parameters(state_); }
  [[nodiscard]] Eigen::VectorXd parameters(const Eigen::VectorXd& state) const;
  /// Curve with the band that the parameters' covariance gives to first order.
  [[nodiscard]] Series curve(const Eigen::VectorXd& deformation, const Eigen::VectorXd& rate) const;

private:
  const EstimationOutcome& outcome_;
  Eigen::Index connector_;
  Eigen::VectorXd state_;
  Eigen::MatrixXd covariance_;
};

/// The law of the connector that a run is about, as it was identified: its force over the rate at zero deformation, or
/// over the deformation at rest where it does not resist a rate, as far as the data went.
struct LawCurve {
  std::string connector;
  bool over_rate = true;
  Eigen::VectorXd abscissa;          ///< [m/s] or [m]
  Eigen::VectorXd force, deviation;  ///< [N]
};
/// Nothing where no connector has an unknown parameter, or its law has a memory.
std::optional<LawCurve> law_curve(const EstimationOutcome& outcome);

}  // namespace kalfem
