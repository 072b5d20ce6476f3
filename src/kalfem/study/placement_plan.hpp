// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/placement/placement.hpp"

namespace kalfem {

struct CaseStudy;

/// Where a candidate stands, for pictures.
struct CandidatePlace {
  std::string substructure = {};
  std::optional<Eigen::Index> node = {};  ///< of a finite-element substructure's mesh
};

/// What `place` asks of a case, with every name looked up and every number in SI.
struct PlacementPlan : PlacementProblem {
  std::vector<CandidatePlace> places;  ///< one per candidate
};

/// The plan of a case with `place`. Problems go to `issues` with their place.
PlacementPlan make_placement_plan(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
