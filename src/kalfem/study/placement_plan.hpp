// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/identification/candidate_information.hpp"
#include "kalfem/information/sensor_placement.hpp"
#include "kalfem/sampling/prior.hpp"

namespace kalfem {

struct CaseStudy;

/// Where a candidate stands, for pictures.
struct CandidatePlace {
  std::string substructure = {};
  std::optional<Eigen::Index> node = {};  ///< of a finite-element substructure's mesh
};

/// What `place` asks of a case, with every name looked up and every number in SI.
struct PlacementPlan {
  std::vector<CandidateSensor> candidates;  ///< first the sensors that stay, see SensorPlacementOptions::fixed
  std::vector<CandidatePlace> places;       ///< one per candidate
  std::vector<std::size_t> own;  ///< candidates at which the case's sensors stand; empty: some stand elsewhere
  /// Unknowns of `estimate` that do not drift: first the `counted` ones that shall be known well, then the others,
  /// which are unknown beside them.
  std::vector<std::string> unknowns;
  std::vector<std::string> units;  ///< of these
  Eigen::VectorXd initial;         ///< their initial values [unit]
  JointPrior prior;                ///< of these, independent
  std::size_t counted = 0;
  SensorPlacementOptions options;  ///< scale and prior are those of the counted unknowns
  int draws = 1;  ///< values of the unknowns from the prior that the choice is averaged over; 1: the initial values
  std::uint64_t seed = 1;
  Record drive;  ///< without channels: the samples of the expected record
};

/// The plan of a case with `place`. Problems go to `issues` with their place.
PlacementPlan make_placement_plan(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
