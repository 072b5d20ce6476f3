// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// What is made small or large by the choice of sensors; I: the information of a set, with the prior's if there is one.
enum class PlacementCriterion {
  d_optimality,        ///< ln det I
  a_optimality,        ///< -tr I^-1, in scaled parameters
  e_optimality,        ///< the smallest eigenvalue of I, in scaled parameters
  expected_deviation,  ///< -sqrt of the mean posterior variance of the chosen parameters, in scaled parameters
  mutual_information,  ///< 1/2 ln det(I + I_prior) - 1/2 ln det I_prior [nat]; needs a prior
};

/// A place for a sensor, or for a group of channels that stand or fall together (a triaxial sensor). One information
/// matrix for each parameter value that the choice shall be robust over; none where a set function is given.
struct SensorCandidate {
  std::string name;
  std::vector<Eigen::MatrixXd> information = {};  ///< [1/(unit_i unit_j)]
};

/// The information of a set of candidates (ascending indices), one matrix for each parameter value, where it is not the
/// sum of the candidates'. Empty where it cannot be computed. May be called from several threads.
using SetInformation = std::function<std::optional<std::vector<Eigen::MatrixXd>>(const std::vector<std::size_t>&)>;

enum class Robustness { mean, worst_case };  ///< of the criterion over the parameter values

struct SensorPlacementOptions {
  std::size_t sensors = 1;  ///< to place
  PlacementCriterion criterion = PlacementCriterion::d_optimality;
  Robustness robustness = Robustness::mean;
  Eigen::VectorXd scale = {};                ///< of the parameters [unit]; empty: ones
  Eigen::VectorXd prior_deviation = {};      ///< [unit]; empty: no prior
  std::vector<std::size_t> parameters = {};  ///< chosen, for expected_deviation; empty: all
  std::vector<std::string> fixed = {};       ///< candidates that every set holds
  double most_sets = 20'000;                 ///< up to which all sets are enumerated; beyond: greedy with exchange
  std::size_t ranked = 1'000;                ///< sets that the result holds at most
  int threads = 1;                           ///< 0: one per processor; results do not depend on it
};

struct RankedSet {
  std::vector<std::size_t> candidates;  ///< ascending
  double criterion = 0.0;               ///< larger is better; -infinity: the parameters are not determined
};

struct SensorPlacement {
  std::vector<RankedSet> sets;  ///< the best first
  bool exact = false;           ///< all sets were tried
  double tried = 0.0;           ///< sets
  std::size_t failed = 0;       ///< whose information could not be computed

  [[nodiscard]] const RankedSet& best() const { return sets.front(); }
};

/// Best sets of sensors for information that adds up over the candidates. Throws InvalidInput for doubled or unknown
/// names, more sensors than candidates, sizes that do not fit, or a criterion that lacks its prior.
SensorPlacement place_sensors(const std::vector<SensorCandidate>& candidates, const SensorPlacementOptions& options);

/// The same for information that does not add up.
SensorPlacement place_sensors(const std::vector<SensorCandidate>& candidates, const SetInformation& information,
                              const SensorPlacementOptions& options);

/// The criterion of information matrices, one for each parameter value; larger is better.
double placement_criterion(const std::vector<Eigen::MatrixXd>& information, const SensorPlacementOptions& options);

}  // namespace kalfem
