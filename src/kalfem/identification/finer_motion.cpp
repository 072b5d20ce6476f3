// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/finer_motion.hpp"

#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Each row by a spline.
MatrixXd finer(const MatrixXd& samples, Index factor) {
  const Index intervals = samples.cols() - 1;
  MatrixXd fine(samples.rows(), factor * intervals + 1);
  for (Index row = 0; row < samples.rows(); ++row) {
    const VectorXd y = samples.row(row).transpose();
    const VectorXd curvature = not_a_knot_curvature(y);
    for (Index k = 0; k < intervals; ++k)
      for (Index part = 0; part < factor; ++part)
        fine(row, k * factor + part) = spline_segment(y[k], y[k + 1], curvature[k], curvature[k + 1],
                                                      static_cast<double>(part) / static_cast<double>(factor))[0];
    fine(row, factor * intervals) = y[intervals];
  }
  return fine;
}

}  // namespace

BoundaryMotion finer_motion(const BoundaryMotion& motion, Index factor) {
  if (factor <= 1 || motion.acceleration.cols() < 2) return motion;
  return {finer(motion.displacement, factor), finer(motion.velocity, factor), finer(motion.acceleration, factor)};
}

}  // namespace kalfem
