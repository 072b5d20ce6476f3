// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/elements/shell.hpp"

namespace kalfem {

/// Strains of a shell's section: of the mid-surface e, curvatures k, [xx yy 2xy] each, and transverse shear g [xz yz].
/// Strains at the height z above the mid-surface are e + z k.
using SectionStrain = Eigen::Matrix<double, 8, 1>;

/// Strains at the corners of a shell, from those at its integration points.
struct ShellStrains {
  Eigen::Matrix3d axes;                              ///< rows: x and y of the section at the centre, normal
  Eigen::Matrix<double, 8, Eigen::Dynamic> corners;  ///< SectionStrain of each corner

  [[nodiscard]] SectionStrain centre() const { return corners.rowwise().mean(); }
};

/// Strains under the motions [x y z rx ry rz] of each node in turn, as the stiffness of shell3() or shell4() assumes
/// them: with the enhanced membrane strains and the bubble, and the assumed transverse shear. Sampled at the four Gauss
/// points of shell4(), at the middles of the sides of shell3(), and extended linearly to the corners. Constant membrane
/// strain and curvature of flat elements are exact.
/// `section`: of the property, at its thickness; `offset`, `direction`: as of LaminateProperty.
/// Throws ElementShapeError as the elements do.
ShellStrains shell_strains(const Eigen::Matrix3Xd& corners, const ShellStiffness& section, double offset,
                           const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                           const DrillingOptions& drilling = {});

ShellStrains shell3_strains(const Eigen::Matrix<double, 3, 3>& corners, const ShellStiffness& section, double offset,
                            const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                            const DrillingOptions& drilling = {});
ShellStrains shell4_strains(const Eigen::Matrix<double, 3, 4>& corners, const ShellStiffness& section, double offset,
                            const Eigen::Vector3d& direction, const Eigen::VectorXd& motions,
                            const DrillingOptions& drilling = {});

/// Motions of places that stand off the nodes by rigid arms, u = u_node + theta x arm.
Eigen::VectorXd moved_by_arms(Eigen::VectorXd motions, const Eigen::Matrix3Xd& arms);

}  // namespace kalfem
