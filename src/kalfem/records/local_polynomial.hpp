// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// How value and slope of a sampled signal are read off near one sample.
struct LocalPolynomialOptions {
  double half_window = 0.01;  ///< samples within t +- half_window are used [s]
  int degree = 2;
};

/// Position and velocity of every channel at one time, with the standard deviations that the scatter about the fit
/// gives.
struct LocalMotion {
  double time = 0.0;                   ///< [s]
  Eigen::VectorXd position;            ///< one a channel, in the channel's unit
  Eigen::VectorXd velocity;            ///< [the channel's unit / s]
  Eigen::VectorXd position_deviation;  ///< [the channel's unit]
  Eigen::VectorXd velocity_deviation;  ///< [the channel's unit / s]
};

/// Least-squares polynomial through the samples around `sample`, its value and derivative there: a displacement
/// record's initial displacement and velocity. Savitzky and Golay, Anal. Chem. 36 (1964) 1627-1639. Samples that are
/// not finite are left out; near an end the window is what is left of it. Throws InvalidInput where fewer than degree +
/// 2 samples remain in a channel, or an option is out of range.
LocalMotion local_motion(const Record& record, Eigen::Index sample, const LocalPolynomialOptions& options = {});

/// Orthonormal basis of the polynomials up to `degree` over the given abscissae: points x (degree + 1).
Eigen::MatrixXd polynomial_basis(const Eigen::VectorXd& abscissae, int degree);

}  // namespace kalfem
