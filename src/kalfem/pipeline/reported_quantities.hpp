// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/records/error_in_band.hpp"

namespace kalfem {

/// The reported quantities of a model: displacement, velocity and acceleration of its reported points, then
/// deformation, rate and force of its connectors, and the strain of its gauges.
std::vector<OutputDescription> reported_quantities(const CoupledModel& model);

/// The quantity of that point or connector; nullptr if it is not among them.
const PointQuantity* find_quantity(const std::vector<PointQuantity>& quantities, const std::string& point,
                                   ObservedQuantity quantity);

/// Compares the quantities of a run with the truth. One thread.
class TruthComparison {
public:
  /// `settled`: the first sample that counts; `sample_rate` in Hz; `band`: that of the excitation, if it has one.
  TruthComparison(Eigen::Index settled, double sample_rate, std::optional<FrequencyBand> band)
      : settled_(settled), sample_rate_(sample_rate), band_(band) {}

  /// Sets the truth and the error against it; of an acceleration or a strain also the error in the band, of
  /// a strain with a deviation the coverage of its 95 % band.
  void compare(PointQuantity& quantity, const Eigen::VectorXd& truth);

private:
  /// The error in the band, from the first sample that counts.
  double error_in_band(const Eigen::VectorXd& mean, const Eigen::VectorXd& expected);

  Eigen::Index settled_;
  double sample_rate_;
  std::optional<FrequencyBand> band_;
  Eigen::Index samples_ = 0;            ///< of those that `in_band_` compares
  std::optional<ErrorInBand> in_band_;  ///< once there was one
};

/// Modes of every substructure that has degrees of freedom: all of a lumped one, the lowest `count` of finite elements.
std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count);
/// The lowest `count` natural frequencies [Hz] of all parts together: superelements where they are reduced, connectors
/// linear about rest. Empty without joints; with a warning, where a connector has no tangent at rest.
Eigen::VectorXd joined_frequencies(const Study& study, Eigen::Index count, std::vector<std::string>& warnings);
/// These modes of a finite-element substructure at full order.
SubstructureModes modes_of(const FiniteElementPart& part, NormalModes modes);

}  // namespace kalfem
