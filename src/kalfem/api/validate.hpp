// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/estimation/filter_kind.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// What a structure with known parameters is tried on.
struct ValidateOptions {
  std::vector<SensorDescription> sensors;  ///< with their noise
  NamedValues values = {};  ///< of parameters, for instance estimates; all others are the structure's own
  /// First part of the record, from which the initial state is estimated [s]; it does not count. Empty: a tenth.
  std::optional<double> lead_in = {};
  bool from_rest = false;                 ///< instead, the structure is at rest at the first sample
  double process_noise = 0.0;             ///< of the filter: white acceleration [m/s^2/sqrt(Hz)]
  std::optional<FilterKind> filter = {};  ///< if empty, the structure decides
  std::optional<int> substeps = {};       ///< of the filter, for the connectors' forces; empty: 4 of a sample interval
  int threads = 0;                        ///< 0: one per processor; results do not depend on it
};

/// Errors of one sensor, each over rms(measured about its mean). Not a number where there is no comparison.
struct SensorValidation {
  std::string sensor, unit;
  double nrmse = std::numeric_limits<double>::quiet_NaN();  ///< rms(simulated - measured), in open loop
  double noise = nrmse;                                     ///< stated noise: the least error possible
  double one_step = nrmse;  ///< rms(predicted one sample ahead - measured) by the filter; NaN where it stops
};

struct ValidateResult {
  std::vector<SensorValidation> sensors;  ///< in the order of the options
  Record measured;                        ///< one channel a sensor
  Eigen::MatrixXd simulated;              ///< in open loop, sensors x samples; empty after a failure
  double compared_from = 0.0;             ///< time of the first sample that counts [s]
  std::string failure;                    ///< why there is no comparison, in words; empty: there is one
  Verdict verdict;                        ///< whether the structure predicts the record

  /// Whether there is a comparison and the structure predicts the record better than no motion would.
  [[nodiscard]] bool usable() const { return verdict.state() != VerdictState::unusable; }
};

/// Simulates a structure along a record that its parameters were not found from, and compares both: what `validate` of
/// a case gives. The structure's inputs have their signals over the time of the record, whose channels have the
/// sensors' names. The initial state is estimated from the lead-in with the parameters held, then the whole record is
/// simulated without any correction. Throws InvalidInput with every argument that is wrong, by its place; what the
/// numbers do is in the result.
ValidateResult validate(const Structure& structure, const Record& record, const ValidateOptions& options);

}  // namespace kalfem
