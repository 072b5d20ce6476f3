// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/inference_choices.hpp"
#include "kalfem/sampling/prior.hpp"

namespace kalfem {

struct CaseStudy;
struct Study;

/// A parameter whose posterior is sought.
struct InferredParameter {
  std::string name, unit;
  double start = 0.0;                ///< where the search for the maximum begins: the initial value [unit]
  std::optional<double> truth = {};  ///< of a simulated record [unit]
};

enum class SensitivityOutput { frequency, largest_force, mean_nis };

/// Sobol' indices of some outputs of the model about the priors.
struct SensitivityPlan {
  struct Output {
    SensitivityOutput kind = SensitivityOutput::frequency;
    std::string name;            ///< as the case gives it: "frequency.1", "force.suspension", "nis"
    std::string connector = {};  ///< whose force
    Eigen::Index mode = 0;       ///< from 0
  };
  std::vector<Output> outputs;
  int samples = 256;
};

/// The case with another law in one of its connectors, whose inference is part of its own study.
struct LawAlternative {
  std::string name, law;
  std::shared_ptr<const Study> study;
};

/// What `infer` asks of a case, with every name looked up and every number in SI.
struct InferencePlan {
  LikelihoodKind likelihood = LikelihoodKind::filter;
  double correlation_time = 0.0;  ///< of the model's error, for simulations [s]
  PosteriorMethod method = PosteriorMethod::importance;
  int samples = 1000;
  int predictions = 40;  ///< draws whose response is simulated
  std::uint64_t seed = 1;
  std::vector<InferredParameter> parameters;
  JointPrior prior;                     ///< of these parameters, in the same order
  std::vector<std::size_t> profile;     ///< parameters whose profile likelihood is computed
  std::vector<std::string> connectors;  ///< whose law is chosen
  std::vector<LawAlternative> laws;
  std::optional<SensitivityPlan> sensitivity;
  SourceLocation location = {};
};

/// The plan of a case with `infer`. Problems go to `issues` with their place.
InferencePlan make_inference_plan(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
