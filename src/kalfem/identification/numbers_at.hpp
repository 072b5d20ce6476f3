// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// c^T S^-1 c / 2 of changes of numbers, S the variances that are stated of them; without that of number `but`.
double pull(const std::vector<FixedNumber>& numbers, const Eigen::VectorXd& changes, Eigen::Index but = -1);

/// A problem, the filter's model of it and its record, with fixed numbers at other values.
struct ProblemAtNumbers {
  EstimationProblemPtr problem;
  AugmentedModelSetup setup;
  Record record;  ///< as sensors with the gains and clocks that the problem assumes would have recorded it
  Eigen::VectorXd log_jacobian;  ///< ln |d record / d recorded| of each sample
};

/// Numbers, and by how much each differs in a problem that at_numbers() made [its scale].
struct ChangedNumbers {
  std::vector<FixedNumber> numbers = {};
  Eigen::VectorXd changes = {};

  [[nodiscard]] bool empty() const { return numbers.empty(); }
};

/// `changed`, not empty: in each number's scale. Finite elements are reduced at
/// their numbers. Throws InvalidInput where they make no structure, or a sensor's gain would be 0.
ProblemAtNumbers at_numbers(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                            const ChangedNumbers& changed);

}  // namespace kalfem
