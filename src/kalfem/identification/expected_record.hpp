// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// What an experiment can only be foreseen with: every excitation, each with its signal. Adds an issue for each that is
/// unknown.
void check_excitation_is_known(const EstimationProblem& problem, IssueList& issues);

/// The record that the sensors are expected to give at theta: a noise-free simulation of the structure through the
/// sensors under its known excitation, over the samples of `drive`, whose sensor channels are replaced. Unknowns that
/// are not named have their initial values. The noise of the channels is that of the sensors. With it
/// fisher_information() is known before the experiment; as noise moves nothing in it, that is a lower bound where
/// process noise or an uncertain start moves the structure much. Throws InvalidInput where an excitation is unknown;
/// empty where the simulation fails or theta is impossible.
std::optional<Record> expected_record(const EstimationProblemPtr& problem, const Record& drive,
                                      const std::vector<std::string>& names, const Eigen::VectorXd& theta);

}  // namespace kalfem
