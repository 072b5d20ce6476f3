// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/reported_quantities.hpp"

namespace kalfem {

/// The reference solution and the record made from it.
struct SimulationOutcome {
  ConvergedSolution reference;
  Record measurements;                ///< with noise, one channel a sensor
  std::vector<PointQuantity> points;  ///< the reported points and connectors, free of noise
  std::vector<FieldSeries> fields;    ///< for pictures, where the case asks for them
  double seconds = 0.0;
};

}  // namespace kalfem
