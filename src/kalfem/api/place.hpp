// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "kalfem/api/estimate.hpp"
#include "kalfem/information/sensor_placement.hpp"

namespace kalfem {

/// Which sensors to choose of many, for an estimation that is still to come.
struct PlaceOptions {
  std::vector<SensorDescription> candidates;  ///< with their noise
  std::vector<std::string> keep = {};         ///< candidates that every set holds
  int count = 1;                              ///< to place beside those
  std::vector<UnknownDescription> unknowns;
  std::vector<std::string> parameters = {};  ///< unknowns that shall be known well; empty: all
  double duration = 0.0;                     ///< of the record that is to come [s]
  double sample_rate = 0.0;                  ///< [Hz]
  /// How well numbers of the structure are known that are held fixed: they are unknown beside the others.
  std::vector<KnownTo> known_to = {};
  double process_noise = 0.0;  ///< of the filter that checks sets [m/s^2/sqrt(Hz)]
  PlacementCriterion criterion = PlacementCriterion::d_optimality;
  int draws = 1;           ///< from the priors, over which the choice is averaged; 1: the initial values
  std::uint64_t seed = 1;  ///< of these
  double most_sets = 2e4;  ///< up to which all sets are tried; beyond: greedy with exchange
  int threads = 0;         ///< 0: one per processor; results do not depend on it
  Progress progress = {};
};

/// A set of sensors with what it is expected to tell.
struct SensorSet {
  std::vector<std::string> sensors;
  std::optional<std::size_t> rank = {};  ///< among the sets that were tried, from 0; nothing: not among the ranked ones
  double criterion = 0.0;                ///< larger is better
  Eigen::VectorXd std = {};              ///< of each parameter, by the information and its prior [unit]
  Eigen::VectorXd std_by_filter = {};    ///< after a run of the filter over the expected record; empty: not run, failed
};

/// What a candidate tells alone, or beside the sensors that stay.
struct PlacementCandidate {
  std::string name;
  bool kept = false;                     ///< it stays in any set
  bool moves = true;                     ///< under the excitation, with the unknowns
  std::optional<std::size_t> rank = {};  ///< among those that do not stay, from 0
  double std_left = 1.0;                 ///< root mean square of the deviations that are left over those of the priors
};

struct PlaceResult {
  std::vector<std::string> parameters, units;  ///< that count
  Eigen::VectorXd prior;                       ///< their deviations before [unit]
  std::vector<SensorSet> best;                 ///< up to 20, the best first
  std::vector<SensorSet> checked;              ///< the best, two between and the worst, with a run of the filter
  std::vector<PlacementCandidate> candidates;
  std::vector<std::string> remarks;  ///< what the best set does not determine, and candidates that tell nothing
  double tried = 0.0;                ///< sets
  bool exact = false;                ///< all of them
};

/// The sets of candidates that tell most of the unknowns under the structure's inputs, which all have their signals. It
/// is what `place` of a case gives. Throws InvalidInput with every argument that is wrong, by its place ("keep: there
/// is no 'a9'"), and where the structure cannot be simulated at the initial values.
PlaceResult place(const Structure& structure, const PlaceOptions& options);

}  // namespace kalfem
