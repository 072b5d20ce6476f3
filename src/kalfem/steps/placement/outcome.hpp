// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/information/sensor_placement.hpp"

namespace kalfem {

/// A set of sensors with what it is expected to tell.
struct PlacedSet {
  std::vector<std::size_t> candidates = {};  ///< ascending
  std::optional<std::size_t> rank = {};      ///< among the ranked sets, from 0; nothing: it is not among them
  double criterion = 0.0;                    ///< larger is better
  /// Deviation of each parameter by the information and the prior [unit], root mean square over the draws.
  Eigen::VectorXd bound = {};
};

/// A set with the deviations that a run of the filter over its expected record ends with, both at the initial values.
struct CheckedSet {
  PlacedSet set;
  Eigen::VectorXd filter = {};  ///< [unit]; empty: it failed
};

/// What a candidate tells alone, or beside the sensors that stay.
struct CandidateRank {
  std::string name;
  bool kept = false;                     ///< it stays in any set
  bool moves = true;                     ///< under the case's excitation
  std::optional<std::size_t> rank = {};  ///< among the candidates that do not stay, from 0; nothing: it stays
  double criterion = 0.0;                ///< larger is better
  double left = 1.0;  ///< root mean square of the parameters' posterior deviations over those of the prior
};

/// Where sensors tell most of the parameters.
struct PlacementOutcome {
  std::vector<CandidateRank> candidates;
  std::vector<std::string> parameters, units;
  Eigen::VectorXd prior;  ///< deviation of each parameter [unit]
  PlacementCriterion criterion = PlacementCriterion::d_optimality;
  SensorPlacement placement;
  std::vector<PlacedSet> best;      ///< the first of the ranked sets
  std::vector<CheckedSet> checked;  ///< the best, two between, the worst and the case's own
  std::optional<PlacedSet> own;     ///< the case's sensors, where they stand at candidates
  Eigen::Index draws = 1;           ///< parameter values that it is averaged over
  std::vector<std::string>
      remarks;          ///< what the best set does not determine, and candidates that tell nothing, in words
  std::string failure;  ///< why there is no choice, in words; empty: there is one
  double seconds = 0.0;
};

}  // namespace kalfem
