// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {

/// Load cases of a model, checked and factored, and the nodes whose motion and stress are wanted.
struct StaticsProblem {
  std::shared_ptr<const StaticAnalysis> analysis;
  std::vector<NamedNode> points;
};

/// Displacement of a reported point, and the largest mean stress of the cells that meet there.
struct PointResponse {
  std::string name;
  Eigen::Index node = 0;
  Eigen::Matrix<double, 6, 1> displacement;  ///< [x y z rx ry rz] [m, rad]
  std::optional<NodalStress> stress;         ///< of solids and shells
};

/// One load case.
struct SolvedLoadCase {
  StaticSolution solution;
  std::vector<RegionStress> stresses;
  std::vector<std::vector<NodalStress>> nodal;  ///< means, by region
  std::vector<StressPeak> peaks;                ///< of each region that has stresses, the largest first
  std::vector<PointResponse> points;
};

/// Every load case of a problem.
struct SolvedLoadCases {
  std::vector<SolvedLoadCase> cases;
  /// Load cases that are not in equilibrium with their reactions, and springs whose force a preload leaves out, in
  /// words.
  std::vector<std::string> warnings;
};

/// Solves every load case and recovers its stresses.
SolvedLoadCases statics(const StaticsProblem& problem);

/// The node that moves farthest under a load case.
Eigen::Index farthest_node(const StaticSolution& solution);

}  // namespace kalfem
