// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Whether the innovations are what the filter says they are: for a consistent filter NIS is chi-squared with as many
/// degrees of freedom as channels (Bar-Shalom, Li and Kirubarajan 2001, section 5.4).
struct ConsistencySummary {
  double mean_nis = 0.0;
  double expected_nis = 0.0;            ///< mean number of channels measured
  double fraction_in_95 = 0.0;          ///< part of the samples inside the two-sided 95 % band
  Eigen::VectorXd innovation_to_noise;  ///< rms of each channel's innovation / its noise standard deviation
};

/// Over the samples from `first` on. Samples without measurements (NaN) are left out; a figure that no sample gives is
/// not a number.
ConsistencySummary summarise_consistency(const Eigen::VectorXd& nis, const Eigen::VectorXi& measured,
                                         const Eigen::MatrixXd& innovation, const Eigen::VectorXd& noise_deviation,
                                         Eigen::Index first);

}  // namespace kalfem
