// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/structure.hpp"
#include "kalfem/system/sensors/output_description.hpp"

namespace kalfem {

/// A linear substructure that the estimated motion of its boundary drives.
struct DrivenMotionProblem {
  StructurePtr structure;                     ///< its inputs have their signals
  std::shared_ptr<const CoupledModel> model;  ///< the whole structure at the parameters to predict with
  std::string substructure;
  /// Displacement, velocity and acceleration of points, one a sample; null where they are not estimated. That of an
  /// accelerated base is in the accelerations, and not in the other two.
  std::function<const Eigen::VectorXd*(const std::string& point, ObservedQuantity quantity)> estimated;
  double start = 0.0, sample_rate = 0.0;  ///< of the samples [s], [Hz]
  Eigen::Index samples = 0;
  int substeps = 2;  ///< of a large substructure, steps per sample
};

/// A predicted motion of a point, or the strain of a gauge, one a sample.
struct DrivenQuantity {
  std::string place;
  ObservedQuantity quantity = ObservedQuantity::displacement;
  Eigen::VectorXd values;
};

/// Qualified points whose motion drives the substructure: its boundary, and those outside that damping couples to it.
/// Throws InvalidInput as DrivenSubstructure does.
std::vector<std::string> driving_points(const StructureModel& structure, const CoupledModel& model,
                                        const std::string& substructure);

/// Displacement and acceleration of every reported point of the substructure, then the strain of its gauges. A lumped
/// substructure starts at its estimated state, a finite-element one in the static shape of its boundary's motion.
/// Throws InvalidInput where a point that drives it is not estimated, and as DrivenSubstructure does.
std::vector<DrivenQuantity> predict(const DrivenMotionProblem& problem, const Progress& progress = {});

}  // namespace kalfem
