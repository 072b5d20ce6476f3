// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/enhanced_solid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace kalfem {
namespace {

/// Cartesian strains [xx yy zz xy yz xz] of natural ones [rr ss tt rs st rt]: e = g^-T E g^-1, g the tangents.
Matrix6 natural_to_cartesian(const Eigen::Matrix3d& tangents) {
  static constexpr int row[] = {0, 1, 2, 0, 1, 0}, column[] = {0, 1, 2, 1, 2, 2};
  const Eigen::Matrix3d inverse = tangents.inverse();
  Matrix6 transform;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d a = inverse.row(row[k]), b = inverse.row(column[k]);
    const Eigen::Matrix3d strain = 0.5 * (a * b.transpose() + b * a.transpose());
    for (int i = 0; i < 6; ++i) transform(i, k) = (i < 3 ? 1.0 : 2.0) * strain(row[i], column[i]);
  }
  return transform;
}

ModeMatrix hexahedron_modes(const Eigen::Vector3d& place) {
  const double r = place[0], s = place[1], t = place[2];
  ModeMatrix modes = ModeMatrix::Zero(6, 9);
  modes(0, 0) = r;
  modes(1, 1) = s;
  modes(2, 2) = t;
  modes.block<1, 2>(3, 3) << r, s;
  modes.block<1, 2>(4, 5) << s, t;
  modes.block<1, 2>(5, 7) << r, t;
  return modes;
}

ModeMatrix wedge_modes(const Eigen::Vector3d& place) {
  const double r = place[0] - 1.0 / 3.0, s = place[1] - 1.0 / 3.0, t = place[2];
  ModeMatrix modes = ModeMatrix::Zero(6, 12);
  modes.block<1, 2>(0, 0) << r, s;
  modes.block<1, 2>(1, 2) << r, s;
  modes.block<1, 2>(3, 4) << r, s;
  modes(2, 6) = t;
  modes(5, 7) = t;
  modes(4, 8) = t;
  modes(5, 9) = r;
  modes(4, 10) = s;
  modes(5, 11) = s;
  modes(4, 11) = r;
  return modes;
}

}  // namespace

ModeMatrix enhanced_strains(CellShape shape, const Eigen::Vector3d& place, const Eigen::Matrix3d& centre, double j) {
  const double ratio = centre.determinant() / j;
  const Matrix6 transform = natural_to_cartesian(centre);
  if (shape == CellShape::wedge6) return ratio * transform * wedge_modes(place);
  ModeMatrix modes = ModeMatrix::Zero(6, 12);
  modes.leftCols<9>() = ratio * transform * hexahedron_modes(place);
  const double r = place[0], s = place[1], t = place[2];
  for (int i = 0; i < 3; ++i) modes.block<1, 3>(i, 9) = ratio * Eigen::RowVector3d(r * s, s * t, r * t);
  return modes;
}

Eigen::Matrix3d centre_tangents(CellShape shape, const SolidNodes& nodes) {
  const Eigen::Vector3d centre =
      shape == CellShape::wedge6 ? Eigen::Vector3d(1.0 / 3.0, 1.0 / 3.0, 0.0) : Eigen::Vector3d::Zero();
  return nodes * solid_shape_functions(shape, centre).slopes;
}

std::vector<EnhancedPoint> enhanced_points(CellShape shape, const SolidNodes& nodes) {
  const Eigen::Matrix3d centre = centre_tangents(shape, nodes);
  std::vector<EnhancedPoint> points;
  for (const auto& point : solid_points(integration_rule(shape, RulePurpose::strain), nodes))
    points.push_back(
        {strain_matrix(point.gradients), enhanced_strains(shape, point.place, centre, point.jacobian), point.volume});
  return points;
}

Condensation condense(const std::vector<EnhancedPoint>& points, const Matrix6& elasticity) {
  const Eigen::Index size = points.front().strains.cols(), modes = points.front().modes.cols();
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size), coupling = Eigen::MatrixXd::Zero(modes, size),
                  inner = Eigen::MatrixXd::Zero(modes, modes);
  for (const auto& point : points) {
    const StrainMatrix stresses = point.volume * elasticity * point.strains;
    stiffness.noalias() += point.strains.transpose() * stresses;
    coupling.noalias() += point.modes.transpose() * stresses;
    inner.noalias() += point.modes.transpose() * (point.volume * elasticity * point.modes);
  }
  Condensation condensation{{}, -inner.llt().solve(coupling)};
  condensation.stiffness = stiffness + coupling.transpose() * condensation.amounts;
  return condensation;
}

}  // namespace kalfem
