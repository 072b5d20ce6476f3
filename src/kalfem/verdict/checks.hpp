// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <string>
#include <vector>

#include "kalfem/statistics/whiteness.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// The innovations of a run, as the filter gives them. A value that is not a number is missing.
struct InnovationRecord {
  std::vector<std::string> sensors, units;
  Eigen::VectorXd noise;                  ///< standard deviation per sensor: stated, or the mean of what was adapted
  Eigen::MatrixXd innovation;             ///< sensors x samples
  Eigen::MatrixXd deviation;              ///< that the filter expects, sensors x samples
  double sample_rate = 1.0, start = 0.0;  ///< [Hz], [s]
  Eigen::Index first = 0;                 ///< first sample that counts: what comes before is settling
  Eigen::VectorXd nis = {};               ///< normalised innovation squared per sample; empty: not judged
  Eigen::VectorXi measured = {};          ///< its degrees of freedom: channels measured
  bool adapted_noise = false;             ///< `noise` was found along the record
};

/// One sensor's normalised innovations e = innovation / deviation, white with variance one for a consistent filter.
struct SensorConsistency {
  double ratio = 1.0;                       ///< rms of e
  double largest_part = 1.0;                ///< rms of e in the loudest twentieth of the record
  double part_begin = 0.0, part_end = 0.0;  ///< of that part [s]
  Autocorrelation lag_one;
  Eigen::Index samples = 0;       ///< that count
  double beyond_half_gate = 0.0;  ///< part of them with e^2 above half of 25, expected 0.0004

  /// Samples that are worth as much and independent: N (1 - rho^2) / (1 + rho^2) for second moments.
  [[nodiscard]] double independent_samples() const;
  /// Factor by which deviations of parameters are too small because of size and correlation together, about.
  [[nodiscard]] double widening() const;
};

std::vector<SensorConsistency> sensor_consistency(const InnovationRecord& record);

/// The innovations of all sensors together: NIS is chi-squared with as many degrees of freedom as channels measured.
struct NisConsistency {
  double ratio = 1.0;                       ///< sum of NIS / sum of degrees of freedom
  double largest_part = 1.0;                ///< the same in the loudest twentieth of the record
  double part_begin = 0.0, part_end = 0.0;  ///< of that part [s]
  double beyond_half_gate = 0.0;     ///< part of the samples less likely than half of 25 is of one channel: 0.0004
  double independent_samples = 0.0;  ///< of NIS, by its autocorrelation
  double mean_degrees = 0.0;         ///< of freedom
  Eigen::Index samples = 0;          ///< that count
};

NisConsistency nis_consistency(const InnovationRecord& record);

/// Reasons that the innovations give, sensor by sensor: larger than expected over the record, in a part of it or in
/// more than 5 % of the time ("innovation_large", "innovation_large_in_part", "innovation_large_often"), correlated in
/// time
/// ("innovation_correlated"), smaller than expected ("noise_too_large"), single outliers ("outliers"). Where no single
/// sensor's size says it, NIS says the same of all together ("nis_large", "nis_large_in_part"): innovations of several
/// sensors that are wrong in common. Each reason needs both: it is significant, four standard deviations beyond chance,
/// and it matters, a factor of `suspicious_widening` or more in standard deviations.
/// Bar-Shalom, Li and Kirubarajan (2001), section 5.4; the limits of size in time are those of PX4's checks after a
/// flight.
std::vector<Reason> innovation_reasons(const InnovationRecord& record);

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One unknown of the filter at the end of a run, beside its prior. Moves and deviations are those of the filter's
/// state, which is the parameter or its transform.
struct EstimatedUnknown {
  std::string name, unit;
  double initial = 0.0, estimate = 0.0;  ///< [unit]
  double moved = 0.0;                    ///< from the prior's mean, in prior standard deviations
  double shrinkage = 0.0;                ///< posterior over prior standard deviation
  double deviation = 0.0;                ///< [unit]
  double widening = 1.0;                 ///< robust over stated standard deviation
  bool too_sure = false;                 ///< as the filter linearised about moving estimates
  bool drifts = false;                   ///< it may change along the record: its prior is soon forgotten
  /// What its nature allows [unit], a stiffness no value below 0; and what the case allows by transform and bounds.
  double least = -infinity, greatest = infinity, lower_bound = -infinity, upper_bound = infinity;
};

/// What contradicts the priors of the unknowns: an estimate further from its first guess than four prior deviations
/// ("far_from_prior"), outside what its nature allows ("out_of_range"), with the other sign ("sign_changed"), at a
/// bound of its transform ("at_bound"), one that the record says nothing about ("not_identified"), two that it cannot
/// tell apart ("correlated") or three and more ("combination"), and deviations that are too small because innovations
/// are correlated ("deviation_too_small") or as the filter linearised about moving estimates ("too_sure").
/// `correlation`: of the unknowns at the end, p x p. The filter linearises about its estimate: one that travelled far
/// while the mean NIS is more than a fifth above the expected one is not to be trusted.
std::vector<Reason> unknown_reasons(const std::vector<EstimatedUnknown>& unknowns,
                                    const Eigen::Ref<const Eigen::MatrixXd>& correlation, double mean_nis,
                                    double expected_nis);

}  // namespace kalfem
