// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// One unit of the last decimal to which the stamps are written, from the last of them: formats with a fixed number of
/// digits are coarsest there. Zero when they have all the digits of a double.
double resolution(const Eigen::VectorXd& stamps);

/// Median over windows of many intervals: neither rounding nor a few gaps move it.
double typical_interval(const Eigen::VectorXd& stamps);

/// The number of fewest decimals within `uncertainty` of the rate.
double roundest(double rate, double uncertainty);

/// Times that are start + k interval.
struct EvenTimes {
  double start = 0.0;
  double interval = 0.0;  ///< [s], > 0
};

/// The even times that the stamps are, up to rounding to their last decimal and a thousandth of the interval: every
/// interval, and every stamp against the straight line from the first to the last. Nothing where they are uneven.
std::optional<EvenTimes> even_times(const Eigen::VectorXd& stamps);

/// Gives a channel the times of its samples [s]: start and interval where they are even, else as they are.
void set_times(MeasuredChannel& channel, const Eigen::VectorXd& stamps);

}  // namespace kalfem
