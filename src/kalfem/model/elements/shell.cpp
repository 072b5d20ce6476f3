// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kalfem/model/elements/shell_strains.hpp"

namespace kalfem {

double relative_shear_modulus(double poissons_ratio) { return 0.5 / (1.0 + poissons_ratio); }

Eigen::Matrix3d plane_stress(double poissons_ratio) {
  const double nu = poissons_ratio;
  const Eigen::Matrix3d stiffness{{1.0, nu, 0.0}, {nu, 1.0, 0.0}, {0.0, 0.0, (1.0 - nu) / 2.0}};
  return stiffness / (1.0 - nu * nu);
}

ShellStiffness isotropic_section(double poissons_ratio, double thickness) {
  const Eigen::Matrix3d material = plane_stress(poissons_ratio);
  return {.membrane = thickness * material,
          .bending = std::pow(thickness, 3) / 12.0 * material,
          .shear = shear_correction * thickness * relative_shear_modulus(poissons_ratio) * Eigen::Matrix2d::Identity()};
}

void require_distinct(const Eigen::Matrix3Xd& corners) {
  if (!corners.allFinite()) throw ElementShapeError("a coordinate of its nodes is not a finite number");
  const double extent = (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).norm();
  // Nearer than this, the distance is the rounding of the coordinates.
  const double nearest = std::max(1e-8 * extent, 1e-14 * corners.cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < corners.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (!((corners.col(i) - corners.col(j)).norm() > nearest))
        throw ElementShapeError("its corners " + std::to_string(j + 1) + " and " + std::to_string(i + 1) + " coincide");
}

// Projects the direction onto the tangent plane: a - (a . n) n, normalised. A projection shorter than 1e-6 of the
// direction is rounding, so the direction counts as parallel to the normal.
Eigen::Vector3d axis_in_surface(const Eigen::Vector3d& direction, const Eigen::Vector3d& first_side,
                                const Eigen::Vector3d& normal) {
  const Eigen::Vector3d& axis = direction.isZero(0.0) ? first_side : direction;
  const Eigen::Vector3d across = axis - axis.dot(normal) * normal;
  if (!(across.norm() > 1e-6 * axis.norm()))
    throw ElementShapeError(
        "the x axis of its section is parallel to its normal and defines no direction in its plane");
  return across.normalized();
}

PlateMass plate_mass(const Eigen::MatrixXd& shares, MassKind mass_kind) {
  const Eigen::Index nodes = shares.rows();
  const Eigen::MatrixXd masses = mass_kind == MassKind::consistent
                                     ? Eigen::MatrixXd(0.5 * (shares + shares.transpose()))
                                     : Eigen::MatrixXd(shares.rowwise().sum().asDiagonal());
  PlateMass mass;
  mass.translation = mass.rotation = Eigen::MatrixXd::Zero(6 * nodes, 6 * nodes);
  for (Eigen::Index i = 0; i < nodes; ++i)
    for (Eigen::Index j = 0; j < nodes; ++j) {
      mass.translation.block<3, 3>(6 * i, 6 * j).diagonal().setConstant(masses(i, j));
      mass.rotation.block<3, 3>(6 * i + 3, 6 * j + 3).diagonal().setConstant(masses(i, j));
    }
  return mass;
}

std::vector<ElementTerm> isotropic_mass(const PlateMass& mass, double nonstructural_mass) {
  std::vector<ElementTerm> terms = {{{.density = 1, .thickness = 1}, mass.translation},
                                    {{.density = 1, .thickness = 3}, mass.rotation / 12.0}};
  if (nonstructural_mass != 0.0) terms.push_back({{}, nonstructural_mass * mass.translation});
  return terms;
}

std::vector<ElementTerm> section_mass(const PlateMass& mass, double amount, double rotary_inertia) {
  return {{{}, amount * mass.translation + rotary_inertia * mass.rotation}};
}

// Transforms every term by A -> T^T A T, T = [I, -[r x]; 0, I] per node: u = u_node + theta x r for the arm r. The
// result is symmetrised, since rounding of the triple product would leave two triangles that differ.
void carry_to_nodes(ElementMatrices& matrices, const Eigen::Matrix3Xd& arms) {
  const Eigen::Index size = 6 * arms.cols();
  Eigen::MatrixXd transform = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < arms.cols(); ++i) {
    const Eigen::Vector3d arm = arms.col(i);
    transform.block<3, 3>(6 * i, 6 * i + 3) << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(), -arm.x(), 0.0;
  }
  for (auto* terms : {&matrices.stiffness, &matrices.mass})
    for (auto& term : *terms) {
      const Eigen::MatrixXd carried = transform.transpose() * term.matrix * transform;
      term.matrix = 0.5 * (carried + carried.transpose());
    }
}

ElementMatrices laminate(const Eigen::Matrix3Xd& corners, const LaminateProperty& property,
                         const Eigen::Vector3d& direction, MassKind mass_kind, const DrillingOptions& drilling) {
  return corners.cols() == 3 ? shell3(corners, property, direction, mass_kind, drilling)
                             : shell4(corners, property, direction, mass_kind, drilling);
}

Eigen::VectorXd moved_by_arms(Eigen::VectorXd motions, const Eigen::Matrix3Xd& arms) {
  for (Eigen::Index i = 0; i < arms.cols(); ++i)
    motions.segment<3>(6 * i) += motions.segment<3>(6 * i + 3).cross(arms.col(i));
  return motions;
}

ShellStrains shell_strains(const Eigen::Matrix3Xd& corners, const ShellStiffness& section, double offset,
                           const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                           const DrillingOptions& drilling) {
  return corners.cols() == 3 ? shell3_strains(corners, section, offset, direction, motions, drilling)
                             : shell4_strains(corners, section, offset, direction, motions, drilling);
}

}  // namespace kalfem
