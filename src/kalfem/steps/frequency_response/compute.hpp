// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/steps/frequency_response/outcome.hpp"
#include "kalfem/study/frequency_response_plan.hpp"

namespace kalfem {

/// Computes the responses of the models that the plan asks for, their peaks and how far the models are apart.
/// `warnings`: reduced models that hold no modes at the highest lines. Throws InvalidInput where the equations of a
/// line are singular, see direct_responses().
FrequencyResponseOutcome run_frequency_response(const FrequencyResponsePlan& plan, const Progress& progress,
                                                std::vector<std::string>& warnings);

/// How far `reduced` is from `full`, given the lines at which `full` peaks.
ResponseDifference difference_of(const Eigen::VectorXd& frequencies, const Eigen::VectorXcd& full,
                                 const Eigen::VectorXcd& reduced, const std::vector<Eigen::Index>& peak_lines);

}  // namespace kalfem
