// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/records/record_preparation.hpp"

namespace kalfem {

struct RecordEstimate;

/// How a motion lies about its mean: [z; z'; internal states], each row over the samples of a record.
struct MotionRange {
  Eigen::VectorXd mean, reach;  ///< reach: the largest distance from the mean
  Eigen::Index dofs = 0;
};

/// `motion`: [z; z'; internal states] x samples.
MotionRange range_of(const Eigen::MatrixXd& motion, Eigen::Index dofs);

/// The motion that a filter estimated.
MotionRange range_of(const RecordEstimate& estimate);

/// A structure whose parameters are known, with the sensors that observe it.
struct EstimatedStructure {
  StructurePtr structure;             ///< as given; what the parts do not hold
  StructureParts parts;               ///< at the values that were found
  std::vector<Sensor> sensors;        ///< with their noise
  EstimationSettings settings;        ///< of the filter, without unknowns
  std::vector<SensorOffset> offsets;  ///< of the sensors, each about the value that was found
};

/// The structure of a problem at the last estimates of a filter. `parts`: hold all that was found in the linear part
/// and by an updating; unknowns that connectors carry are set here. Rest positions of sensors are left out: they belong
/// to the record that they were found from.
EstimatedStructure at_estimates(const EstimationProblem& problem, StructureParts parts, const RecordEstimate& estimate);

/// A record of the same sensors without the gains and delays that were found.
PreparedRecord without_sensor_errors(PreparedRecord prepared, const RecordEstimate& estimate);

}  // namespace kalfem
