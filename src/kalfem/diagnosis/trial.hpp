// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "kalfem/diagnosis/hypothesis.hpp"

namespace kalfem {

/// A run in which a mistake is undone, see Correction.
struct CorrectedRun {
  FilterRun run;
  double log_jacobian = 0.0;
};

/// How well a run fits its record.
struct TrialScore {
  double log_likelihood = -std::numeric_limits<double>::infinity();
  double mean_nis = 0.0, expected_nis = 0.0;
  double widening = 1.0;  ///< the largest of a sensor
  double loudest_part =
      1.0;  ///< the largest of a sensor: rms of its normalised innovations in a twentieth of the record
  Eigen::VectorXd estimates;
  Eigen::VectorXi samples;  ///< present in each channel
};

/// The first samples of a record, or all.
Record first_samples(Record record, Eigen::Index samples);

/// The run over the first samples of its record.
CorrectedRun first_part(CorrectedRun corrected, Eigen::Index samples);

/// Runs the filter. `expected`: samples of each channel in the run as it was given; those that a correction takes away
/// count as much as the channel's mean. Empty for that run itself.
TrialScore score_of(const CorrectedRun& corrected, const EstimationOptions& options, const Eigen::VectorXi& expected);

}  // namespace kalfem
