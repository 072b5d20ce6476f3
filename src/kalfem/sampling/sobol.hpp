// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kalfem/sampling/prior.hpp"

namespace kalfem {

/// Outputs of a model at theta; not a number where one is unknown. Called from several threads.
using ModelOutputs = std::function<Eigen::VectorXd(const Eigen::VectorXd& theta)>;

enum class SobolPoints { scrambled, plain, random };  ///< Sobol' points with a random digital shift, as they are, none

struct SobolOptions {
  int samples = 1024;  ///< N; the model is called N (p + 2) times. A power of two suits Sobol' points.
  SobolPoints points = SobolPoints::scrambled;
  int bootstrap = 500;       ///< resamples for the confidence bounds
  double confidence = 0.95;  ///< of the bounds
  std::uint64_t seed = 1;
  int threads = 1;  ///< results do not depend on it
};

IssueList validate(const SobolOptions& options);

/// An index with its confidence bounds.
struct SobolIndex {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

/// Of one output.
struct SobolIndices {
  double mean = 0.0;
  double variance = 0.0;
  std::vector<SobolIndex> first;  ///< S_i = Var(E[y | theta_i]) / Var(y), one per parameter
  std::vector<SobolIndex> total;  ///< T_i = E[Var(y | all but theta_i)] / Var(y)
  int left_out = 0;               ///< samples of N for which some output was not a number
};

/// Sobol' indices of each output about independent parameters with the matrices A, B and A_B^(i) of Saltelli et al.
/// (2010, Comput. Phys. Commun. 181, 259-270): first-order by Saltelli's, total by Jansen's estimator,
///     S_i = 1/N sum f(B) (f(A_B^(i)) - f(A)) / V,   T_i = 1/(2 N) sum (f(A) - f(A_B^(i)))^2 / V.
/// Indices are zero where an output does not vary. Throws InvalidInput for a correlated prior, options out of range,
/// outputs of changing number, and where fewer than two samples are left.
std::vector<SobolIndices> sobol_indices(const JointPrior& prior, const ModelOutputs& model,
                                        const SobolOptions& options = {});

}  // namespace kalfem
