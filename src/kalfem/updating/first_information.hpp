// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/information/parameter_groups.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// How the natural frequencies of a comparison follow the parameters at the initial values.
struct FrequencySensitivities {
  std::string comparison;
  Eigen::VectorXd measured;  ///< [Hz]
  Eigen::MatrixXd relative;  ///< d ln f / d ln theta, modes x parameters; of a parameter that is 0, d ln f per scale
};

/// What the comparisons tell of the parameters before anything is updated.
struct FirstInformation {
  std::vector<FrequencySensitivities> frequencies;  ///< one a comparison of modes
  Identifiability told;                             ///< by all comparisons, from J^T J at the initial values
  std::vector<std::string> remarks;                 ///< combinations that they do not determine, one sentence each
  ParameterGrouping proposal;                       ///< whose groups they determine; as many as parameters: none needed
};

/// A comparison in the sum of residuals.
struct ComparedResidual {
  std::string name;
  ResidualPtr residual;
  double weight = 1.0;
};

/// `first`: value and Jacobian of the sum of the comparisons, in their order, at the initial values.
FirstInformation first_information(const std::vector<UpdatingParameter>& parameters, const ResidualValue& first,
                                   const std::vector<ComparedResidual>& comparisons);

/// Groups of two and more parameters in words, one sentence each, then those to hold.
std::vector<std::string> proposal_in_words(const std::vector<UpdatingParameter>& parameters,
                                           const ParameterGrouping& proposal);

}  // namespace kalfem
