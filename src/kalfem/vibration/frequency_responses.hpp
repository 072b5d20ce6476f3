// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/structure.hpp"
#include "kalfem/updating/frf_set.hpp"
#include "kalfem/vibration/computed_response.hpp"

namespace kalfem {

/// Which frequency responses of a structure to compute.
struct FrequencyResponseProblem {
  Eigen::VectorXd frequencies;  ///< [Hz], ascending
  std::vector<FrfSet> sets;
  ResponseModel model = ResponseModel::full;
  ResponseMethod method = ResponseMethod::modal;
  StructureParts parts;  ///< finite elements at full order; the inputs are the grounds that move
  std::vector<FiniteElementSubstructure> finite_elements;  ///< in the order of parts.finite_elements
  std::shared_ptr<const LinearModel> full;                 ///< of the parts, linear about rest
};

/// Computes the responses of the models that the problem asks for, their peaks and how far the models are apart. Throws
/// InvalidInput where the equations of a line are singular, see direct_responses().
FrequencyResponses frequency_responses(const FrequencyResponseProblem& problem, const Progress& progress = {});

/// How far `reduced` is from `full`, given the lines at which `full` peaks.
ResponseDifference difference_of(const Eigen::VectorXd& frequencies, const Eigen::VectorXcd& full,
                                 const Eigen::VectorXcd& reduced, const std::vector<Eigen::Index>& peak_lines);

}  // namespace kalfem
