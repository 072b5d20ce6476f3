// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>

namespace kalfem {

/// A point of a test's geometry: a sensor of one axis or three.
struct TestPoint {
  std::string name;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();     ///< in the test's axes [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: the sensor's x, y, z in the test's axes
};

}  // namespace kalfem
