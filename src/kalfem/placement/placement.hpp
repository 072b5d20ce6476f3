// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/candidate_information.hpp"
#include "kalfem/information/sensor_placement.hpp"
#include "kalfem/sampling/prior.hpp"

namespace kalfem {

/// Where sensors would tell most of the unknowns of an estimation problem, before anything was measured.
struct PlacementProblem {
  EstimationProblemPtr problem;             ///< with the unknowns; every excitation has its signal
  std::vector<CandidateSensor> candidates;  ///< first the sensors that stay, see SensorPlacementOptions::fixed
  std::vector<std::size_t> own = {};        ///< candidates that are the problem's own sensors; empty: not all are
  /// Unknowns that do not drift: first the `counted` ones that shall be known well, then the others, which are unknown
  /// beside them.
  std::vector<std::string> unknowns;
  std::vector<std::string> units;  ///< of these
  Eigen::VectorXd initial;         ///< their initial values [unit]
  JointPrior prior;                ///< of these, independent
  std::size_t counted = 0;
  std::vector<std::string> not_counted = {};  ///< stated numbers that the ranking leaves out: gains and delays
  SensorPlacementOptions options;             ///< scale and prior are those of the counted unknowns
  int draws = 1;  ///< values of the unknowns from the prior that the choice is averaged over; 1: the initial values
  std::uint64_t seed = 1;
  Record drive;  ///< without channels: the samples of the expected record
};

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
  bool moves = true;                     ///< under the excitation
  std::optional<std::size_t> rank = {};  ///< among the candidates that do not stay, from 0; nothing: it stays
  double criterion = 0.0;                ///< larger is better
  double left = 1.0;  ///< root mean square of the parameters' posterior deviations over those of the prior
};

/// Where sensors tell most of the parameters.
struct SensorChoice {
  std::vector<CandidateRank> candidates;
  std::vector<std::string> parameters, units;
  Eigen::VectorXd prior;  ///< deviation of each parameter [unit]
  PlacementCriterion criterion = PlacementCriterion::d_optimality;
  SensorPlacement placement;
  std::vector<PlacedSet> best;      ///< the first of the ranked sets
  std::vector<CheckedSet> checked;  ///< the best, two between, the worst and the own ones
  std::optional<PlacedSet> own;     ///< the sensors that the problem has, where they stand at candidates
  Eigen::Index draws = 1;           ///< parameter values that it is averaged over
  std::vector<std::string>
      remarks;          ///< what the best set does not determine, and candidates that tell nothing, in words
  std::string failure;  ///< why there is no choice, in words; empty: there is one
  double seconds = 0.0;

  /// Names of a set's sensors.
  [[nodiscard]] std::vector<std::string> names(const PlacedSet& set) const;
};

/// Ranks sets of candidates by the information that noise-free outputs carry along the expected excitation
/// (candidate_information()), that of unknowns beside the counted ones taken out,
///     I = I_cc - I_co (I_oo + P_o^-1)^-1 I_oc,
/// and runs the filter over the expected records of some sets, which shows what process noise and an unknown start
/// hide. Throws InvalidInput as candidate_information() and place_sensors() do.
SensorChoice place(const PlacementProblem& problem, const Progress& progress = {});

}  // namespace kalfem
