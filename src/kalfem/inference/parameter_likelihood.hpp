// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/inference/inference_problem.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// The likelihood of the parameters of an inference.
struct ParameterLikelihood {
  std::vector<std::string> names;
  LogLikelihood log_likelihood;
  /// Fisher information at theta [1/(unit_i unit_j)]; empty where it cannot be computed.
  std::function<std::optional<Eigen::MatrixXd>(const Eigen::VectorXd& theta)> information;
  std::string words;  ///< what it is made of
  double work = 0.0;  ///< of one likelihood, floating-point operations in order of magnitude
  /// With twice the substeps; null where it has none.
  std::function<double(const Eigen::VectorXd& theta)> finer = {};
};

/// Of a record under the structure's excitation, as the problem's kind says: `filter` or `simulation`. `first`: where
/// the filter's substeps and finite elements' bases are decided. Throws InvalidInput where it cannot be made there.
ParameterLikelihood likelihood_of_record(const InferenceProblem& problem, const Record& record,
                                         const Eigen::VectorXd& first);

/// Likelihoods that searches for further maxima may take: up to four a sample of the posterior, as many as ten seconds
/// or so compute. Operations are counted, not seconds: the same problem searches alike on every machine. None where
/// these are fewer than 100, which would not tell much.
long long search_likelihoods(const ParameterLikelihood& likelihood, int samples);

}  // namespace kalfem
