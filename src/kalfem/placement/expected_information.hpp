// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/placement/placement.hpp"

namespace kalfem {

/// Information of each candidate at one value of the unknowns, p x p [1/(unit_i unit_j)].
using CandidateMatrices = std::vector<Eigen::MatrixXd>;

/// Empty where the structure cannot be simulated at these values.
std::optional<CandidateMatrices> information_at(const PlacementProblem& problem, const Eigen::VectorXd& values);

/// What sets of candidates tell of the unknowns at some values of these.
class ExpectedInformation {
public:
  using Set = std::vector<std::size_t>;

  ExpectedInformation(const PlacementProblem& problem, std::vector<CandidateMatrices> at_values);

  /// Of all unknowns, without the prior, one matrix for each value.
  [[nodiscard]] std::vector<Eigen::MatrixXd> of_all(const Set& set) const;
  /// Of the counted unknowns c, without their prior, while the others o are unknown under theirs:
  ///     I_cc - I_co (I_oo + P_o^-1)^-1 I_oc.
  [[nodiscard]] std::vector<Eigen::MatrixXd> of_counted(const Set& set) const;
  /// Posterior deviations of the counted unknowns, root mean square over the values.
  [[nodiscard]] Eigen::VectorXd deviation(const Set& set) const;
  /// Whether the candidate shows anything of the unknowns.
  [[nodiscard]] bool moves(std::size_t candidate) const;

private:
  Eigen::Index counted_;
  Eigen::VectorXd prior_;  ///< information of the prior
  std::vector<CandidateMatrices> at_values_;
};

}  // namespace kalfem
