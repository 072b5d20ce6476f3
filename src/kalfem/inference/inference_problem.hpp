// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/inference_choices.hpp"
#include "kalfem/sampling/prior.hpp"

namespace kalfem {

/// A parameter whose posterior is sought.
struct InferredParameter {
  std::string name, unit;
  double start = 0.0;                ///< where the search for the maximum begins: the initial value [unit]
  std::optional<double> truth = {};  ///< of a simulated record [unit]
};

enum class SensitivityOutput { frequency, largest_force, mean_nis };

/// Sobol' indices of some outputs of the model about the priors.
struct SensitivityOptions {
  struct Output {
    SensitivityOutput kind = SensitivityOutput::frequency;
    std::string name;            ///< "frequency.1", "force.suspension", "nis"
    std::string connector = {};  ///< whose force
    Eigen::Index mode = 0;       ///< from 0
  };
  std::vector<Output> outputs;
  int samples = 256;
};

/// What data shall tell of some parameters, and how it is computed.
struct InferenceProblem {
  EstimationProblemPtr problem;  ///< whose record it is; may be null where the likelihood is that of other data
  AugmentedModelSetup setup;     ///< the filter's model of it
  std::vector<InferredParameter> parameters;
  JointPrior prior;              ///< of these parameters, in the same order
  std::size_t marginalised = 0;  ///< the last of them, which the result integrates out: marginalise_stated_numbers()
  LikelihoodKind likelihood = LikelihoodKind::filter;
  double correlation_time = 0.0;  ///< of the model's error, for simulations [s]
  PosteriorMethod method = PosteriorMethod::importance;
  int samples = 1000;
  std::uint64_t seed = 1;
  std::vector<std::size_t> profile = {};  ///< parameters whose profile likelihood is computed
  int predictions = 40;                   ///< draws whose response is simulated
  std::optional<SensitivityOptions> sensitivity = {};
  SourceLocation location = {};  ///< where the user asks for it, for messages

  /// Of the estimation problem's settings; one per processor without one. Results do not depend on it.
  [[nodiscard]] int threads() const;
};

/// Names of the parameters, and where their search starts.
std::vector<std::string> names_of(const InferenceProblem& problem);
Eigen::VectorXd start_of(const InferenceProblem& problem);

}  // namespace kalfem
