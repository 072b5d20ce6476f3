// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/error_in_band.hpp"
#include "kalfem/system/coupling.hpp"
#include "kalfem/system/sensors/output_description.hpp"

namespace kalfem {

/// One estimated or predicted quantity of one point, with the reference if there is one.
struct PointQuantity {
  std::string point;
  ObservedQuantity quantity = ObservedQuantity::displacement;
  Eigen::VectorXd mean;
  Eigen::VectorXd deviation;            ///< empty if not known
  Eigen::VectorXd truth;                ///< empty if not known
  std::optional<double> nrmse;          ///< against the truth, after settling
  std::optional<double> nrmse_in_band;  ///< of accelerations and strains: the NRMSE in the excitation's band
  std::optional<double> coverage = {};  ///< of strains: share of the truth in the 95 % band, after settling
};

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

}  // namespace kalfem
