// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/inference/inference_problem.hpp"

namespace kalfem {

struct CaseStudy;
struct Study;

/// The case with another law in one of its connectors, whose inference is part of its own study.
struct LawAlternative {
  std::string name, law;
  std::shared_ptr<const Study> study;
};

/// What `infer` asks of a case, with every name looked up and every number in SI.
struct InferencePlan : InferenceProblem {
  std::vector<std::string> connectors;  ///< whose law is chosen
  std::vector<LawAlternative> laws;
};

/// The plan of a case with `infer`. Problems go to `issues` with their place.
InferencePlan make_inference_plan(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
