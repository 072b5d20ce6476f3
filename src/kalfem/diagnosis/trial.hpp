// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

#include "kalfem/diagnosis/hypothesis.hpp"
#include "kalfem/verdict/verdict.hpp"

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

  [[nodiscard]] bool failed() const { return !std::isfinite(log_likelihood); }
  /// Whether innovations are white and of their size.
  [[nodiscard]] bool leaves_nothing() const { return !failed() && state_of(widening) == VerdictState::consistent; }
};

/// The first samples of a record, or all.
Record first_samples(Record record, Eigen::Index samples);

/// The run over the first samples of its record.
CorrectedRun first_part(CorrectedRun corrected, Eigen::Index samples);

/// Runs the filter. `expected`: samples of each channel in the run as it was given; those that a correction takes away
/// count as much as the channel's mean. Empty for that run itself.
TrialScore score_of(const CorrectedRun& corrected, const EstimationOptions& options, const Eigen::VectorXi& expected);

/// The score with the estimates and innovations of further passes, each from the estimates of the one before, where
/// innovations contradict the model in one pass and less so in the last: a first guess far off is no mistake beside the
/// one that was undone.
TrialScore after_more_passes(TrialScore score, const FilterRun& run, EstimationOptions options);

}  // namespace kalfem
