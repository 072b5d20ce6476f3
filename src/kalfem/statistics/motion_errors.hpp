// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Chi-squared figures of a prediction's errors, each with its degrees of freedom.
struct MotionErrors {
  double followed = 0.0;  ///< of the errors that follow the prediction itself: its gain and phase in ten bands
  double followed_freedom = 0.0;
  double in_band = 0.0;  ///< of all errors at the frequencies of the motion
  double in_band_freedom = 0.0;
};

/// Where a prediction x is right, its errors e are white, of variance one, and independent of it. Bands b of the
/// discrete Fourier transforms E, X that hold a tenth of the energy of x each, and the frequencies M that hold 99 % of
/// it together, give
///     followed = 2/n sum_b |sum_{f in b} E conj(X)|^2 / sum_{f in b} |X|^2,   in_band = 2/n sum_{f in M} |E|^2,
/// chi-squared with two degrees of freedom for each band or frequency: noise in most frequencies counts in neither.
/// Of n samples at the end, n of factors 2, 3 and 5. Zero where x does not move.
MotionErrors motion_errors(const Eigen::VectorXd& errors, const Eigen::VectorXd& prediction);

}  // namespace kalfem
