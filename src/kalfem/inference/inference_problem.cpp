// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/inference_problem.hpp"

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/filter_run.hpp"

namespace kalfem {

int InferenceProblem::threads() const { return problem ? filter_threads(problem->settings) : processors(); }

std::vector<std::string> names_of(const InferenceProblem& problem) {
  std::vector<std::string> names;
  for (const auto& parameter : problem.parameters) names.push_back(parameter.name);
  return names;
}

Eigen::VectorXd start_of(const InferenceProblem& problem) {
  Eigen::VectorXd start(std::ssize(problem.parameters));
  for (std::size_t i = 0; i < problem.parameters.size(); ++i)
    start[static_cast<Eigen::Index>(i)] = problem.parameters[i].start;
  return start;
}

}  // namespace kalfem
