// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <ostream>

namespace kalfem::test {

/// An element by its corners [m].
struct Shape {
  const char* name;
  Eigen::Matrix3Xd corners;
  bool flat = true;

  [[nodiscard]] double size() const { return (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).norm(); }
  [[nodiscard]] double thickness() const { return 0.05 * size(); }
};
inline std::ostream& operator<<(std::ostream& out, const Shape& shape) { return out << shape.name; }

inline Eigen::Matrix3Xd points(std::initializer_list<Eigen::Vector3d> list) {
  Eigen::Matrix3Xd corners(3, static_cast<Eigen::Index>(list.size()));
  Eigen::Index column = 0;
  for (const auto& point : list) corners.col(column++) = point;
  return corners;
}

inline Eigen::Matrix3d some_turn() {
  return Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
}

/// The matrix of an element that is turned with all its motions.
inline Eigen::MatrixXd turned(const Eigen::MatrixXd& matrix, const Eigen::Matrix3d& turn) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  for (Eigen::Index i = 0; i < matrix.rows(); i += 3) all.block<3, 3>(i, i) = turn;
  return all * matrix * all.transpose();
}

/// Difference of two matrices, each entry against the sizes of its diagonal ones: displacements and rotations of
/// elements of any size weigh alike.
inline double scaled_difference(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other) {
  const Eigen::VectorXd scale = other.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (one - other) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace kalfem::test
