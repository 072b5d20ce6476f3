// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model/element_helpers.hpp"

namespace kalfem::test {

/// A distorted plate, turned in space, under membrane strains e and curvatures k [xx yy 2xy] of its own plane.
struct PlatePatch {
  Eigen::Vector3d e, k;
  Eigen::Matrix3d turn = some_turn();
  double offset = 0.0;

  /// Motions of the node at the place x, y of the plate, whose mid-surface is off it.
  [[nodiscard]] Eigen::VectorXd motions(double x, double y) const {
    const double slope_x = -(k[0] * x + 0.5 * k[2] * y), slope_y = -(k[1] * y + 0.5 * k[2] * x);
    Eigen::Vector3d moved(e[0] * x + 0.5 * e[2] * y, e[1] * y + 0.5 * e[2] * x,
                          -0.5 * (k[0] * x * x + k[1] * y * y + k[2] * x * y));
    const Eigen::Vector3d rotation(slope_y, -slope_x, 0.0);
    moved -= rotation.cross(Eigen::Vector3d(0.0, 0.0, offset));
    return (Eigen::VectorXd(6) << turn * moved, turn * rotation).finished();
  }
};

}  // namespace kalfem::test
