// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/api/estimate.hpp"

namespace kalfem {

/// A linear substructure to drive by the estimated motion of its boundary.
struct PredictOptions {
  EstimateOptions estimate;  ///< of the structure from the record
  std::string substructure;
  int steps = 2;  ///< per sample, of a large substructure
};

/// A predicted motion of a point, or the strain of a gauge, at every sample.
struct PredictedQuantity {
  std::string place, unit;
  ObservedQuantity quantity = ObservedQuantity::displacement;
  Eigen::VectorXd values;
};

struct PredictResult {
  EstimateResult estimate;
  /// Displacement and acceleration of every reported point of the substructure, then the strain of its gauges. Empty
  /// where there is nothing to predict from.
  std::vector<PredictedQuantity> predicted;
  std::string failure;  ///< why there is no prediction, in words; empty: there is one

  /// Look-up by place; throws InvalidInput if there is none.
  [[nodiscard]] const PredictedQuantity& at(const std::string& place, ObservedQuantity quantity) const;
};

/// Estimates as estimate() does, then solves one substructure at the estimates exactly, driven by the estimated motion
/// of its boundary: the degrees of freedom that its reduction keeps, or those that connectors touch. Its inner motion
/// then follows its own equations and no process noise. It is what `predict` of a case gives. Throws InvalidInput as
/// estimate() does, and where the substructure cannot be driven.
PredictResult predict(const Structure& structure, const Record& record, const PredictOptions& options);

}  // namespace kalfem
