// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/infer.hpp"
#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/inference/inference_result.hpp"

namespace kalfem {

/// A caller's question in the library's own types, with the record of its sensors.
struct InferenceQuestion {
  InferenceProblem problem;
  Record record;
};

/// Looks up every name and checks every number. Throws InvalidInput with every argument that is wrong, by its place.
InferenceQuestion make_inference_question(const Structure& structure, const Record& record,
                                          const InferOptions& options);

/// What was found, in the form of the result.
InferResult result_of(InferenceResult found);

/// What was found of the parameters, in the form of the result. `posterior`: empty where there is no distribution.
std::vector<PosteriorParameter> posterior_parameters(const std::vector<std::string>& units,
                                                     const std::vector<ParameterSummary>& prior,
                                                     const std::vector<ParameterSummary>& posterior,
                                                     const Eigen::VectorXd& most_probable);

}  // namespace kalfem
