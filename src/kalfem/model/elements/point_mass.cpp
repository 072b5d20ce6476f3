#include "kalfem/model/elements/point_mass.hpp"

namespace kalfem {

Eigen::Matrix<double, 6, 6> point_mass(const PointMass& mass) {
  const auto& o = mass.offset;
  Eigen::Matrix3d cross;
  cross << 0.0, -o.z(), o.y(), o.z(), 0.0, -o.x(), -o.y(), o.x(), 0.0;
  Eigen::Matrix<double, 6, 6> matrix;
  matrix.topLeftCorner<3, 3>() = mass.mass * Eigen::Matrix3d::Identity();
  matrix.topRightCorner<3, 3>() = -mass.mass * cross;
  matrix.bottomLeftCorner<3, 3>() = mass.mass * cross;
  matrix.bottomRightCorner<3, 3>() = mass.inertia - mass.mass * cross * cross;
  return matrix;
}

}  // namespace kalfem
