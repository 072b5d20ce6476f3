// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/information/identifiability.hpp"

namespace kalfem {

/// Information on some unknowns of a problem.
struct OwnInformation {
  std::vector<InformedParameter> parameters;
  Eigen::MatrixXd information;  ///< [1/(unit_i unit_j)]
};

/// candidate_information() of a problem's own sensors together, about the initial values: on its constant unknowns and,
/// behind them, on unknown gains of its sensors, dy/dgain = y / gain. Empty where it has none of these, or a simulation
/// fails. Throws InvalidInput as candidate_information() does.
std::optional<OwnInformation> own_information(const EstimationProblemPtr& problem, const Record& drive,
                                              const FisherInformationOptions& options = {.relative_step = 1e-4});

}  // namespace kalfem
