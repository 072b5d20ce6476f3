// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {

/// Displacement of a reported point, and the largest mean stress of the cells that meet there.
struct PointResponse {
  std::string name;
  Eigen::Index node = 0;
  Eigen::Matrix<double, 6, 1> displacement;  ///< [x y z rx ry rz] [m, rad]
  std::optional<NodalStress> stress;         ///< of solids and shells
};

/// One load case.
struct StaticCaseOutcome {
  StaticSolution solution;
  std::vector<RegionStress> stresses;
  std::vector<std::vector<NodalStress>> nodal;  ///< means, by region
  std::vector<StressPeak> peaks;                ///< of each region that has stresses, the largest first
  std::vector<PointResponse> points;
};

/// Static analysis of a substructure.
struct StaticsOutcome {
  std::string substructure;
  std::vector<StaticCaseOutcome> cases;
  double seconds = 0.0;
};

}  // namespace kalfem
