// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

class FrfResidual;

/// A measured frequency response H beside the model's G, over the lines f that are compared.
struct ResponseAgreement {
  std::string name;                  ///< "acceleration at tip.z per force at root.z"
  double frac = 0.0;                 ///< |sum conj(H) G|^2 / (sum |H|^2 sum |G|^2) in [0, 1], of any scale [HL96]
  double size = 0.0;                 ///< sqrt(sum |G|^2 / sum |H|^2)
  std::optional<double> phase = {};  ///< of sum conj(H) G [rad]; nothing where magnitudes alone were measured

  /// The two agree but for their sign: a sensor, or the force, points the other way.
  [[nodiscard]] bool is_turned() const;
};

ResponseAgreement agreement_of(std::string name, const Eigen::VectorXcd& measured, const Eigen::VectorXcd& model,
                               bool magnitudes_only);

/// Each output of each input at these parameters. Throws InvalidInput where there is no model.
std::vector<ResponseAgreement> agreement_of(const FrfResidual& residual, const Eigen::VectorXd& parameters);

/// What is turned, a sentence each: an output, or the input where most of its outputs are.
std::vector<std::string> turned_ones(const std::vector<ResponseAgreement>& responses);

}  // namespace kalfem
