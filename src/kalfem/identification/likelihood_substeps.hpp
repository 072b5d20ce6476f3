// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// The substeps of a sample interval that FilterLikelihood takes: those of the settings, otherwise as many as an
/// estimation of all unknowns about `first` needs. `names`: those that the likelihood is a function of; `first`: their
/// values. Throws InvalidInput as FilterLikelihood does.
int likelihood_substeps(const EstimationProblemPtr& problem, const Record& record, std::vector<std::string> names,
                        const Eigen::VectorXd& first);

}  // namespace kalfem
