// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"

/// Structures of which modes are measured: each has members whose stiffness may be off, nodes with degrees of freedom
/// "n4.x", and is supported.
namespace kalfem::test {

/// A member or element with its stiffness, over numbers of degrees of freedom; negative ones are held.
struct Member {
  std::vector<int> dofs;
  Eigen::MatrixXd stiffness;
};

struct TestedStructure {
  std::vector<std::string> dofs;
  std::vector<Member> members;
  Eigen::VectorXd masses;         ///< lumped, one a degree of freedom [kg, kg m^2]
  std::vector<std::string> axes;  ///< along which its sensors look

  /// `factors`: one a member; none: 1.
  [[nodiscard]] LinearModel model(const std::vector<double>& factors = {}) const;
};

/// A lattice mast of three legs, twisted and tapered so that no two axes are alike: bars between neighbours and across,
/// EA = 2 MN, 20 kg a joint; axes x, y, z.
TestedStructure mast(int levels);

/// A frame of beams in its plane [Prz68], bays of 5 m and storeys of 3 m, each member of two elements; EI = 20 MN m^2,
/// EA = 2 GN, 200 kg/m of the beams and 80 kg/m of the columns; axes x, y.
TestedStructure plane_frame(int storeys, int bays);

/// A steel plate of 1.2 m x 0.9 m x 10 mm that is clamped at x = 0, of rectangles with twelve degrees of freedom
/// [Mel63]; axis z.
TestedStructure plate(int along, int across);

}  // namespace kalfem::test
