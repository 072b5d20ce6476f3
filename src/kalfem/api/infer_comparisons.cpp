// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/api/infer.hpp"
#include "kalfem/api/inference_question.hpp"
#include "kalfem/api/refined_parameters.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/inference/infer.hpp"
#include "kalfem/inference/residual_likelihood.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

void check_options(const InferOptions& options, const UpdateOptions& comparisons, IssueList& issues) {
  if (options.likelihood != LikelihoodKind::comparisons)
    issues.add({}, "likelihood: that of a record is asked for", "comparisons have a likelihood of their own",
               "take likelihood: comparisons, or give a record");
  if (options.method == PosteriorMethod::filter)
    issues.add({}, "method: filter without a record", "its posterior is what a filter knows at a record's end",
               "take method: importance");
  if (!options.unknowns.empty() || !options.sensors.empty())
    issues.add({}, "unknowns or sensors are given", "they are those of a record", "leave them out");
  if (!options.known_to.empty() || !comparisons.known_to.empty())
    issues.add({}, "known_to is given", "a posterior of comparisons holds other numbers fixed",
               "make them parameters with a prior");
  const auto names = names_of_parameters(comparisons);
  for (const auto& [name, prior] : options.priors)
    if (std::ranges::find(names, name) == names.end())
      issues.add({}, "priors: there is no parameter '" + name + "'" + did_you_mean(name, names), "", "");
}

/// The stated prior of a parameter, or the one that its range means.
MarginalPrior prior_of(const UpdatingParameter& parameter, const InferOptions& options) {
  const auto stated = std::ranges::find(options.priors, parameter.name, &std::pair<std::string, MarginalPrior>::first);
  if (stated != options.priors.end()) return stated->second;
  if (std::isfinite(parameter.deviation))
    return NormalPrior{parameter.initial, parameter.deviation, parameter.lower, parameter.upper};
  return UniformPrior{parameter.lower, parameter.upper};
}

void set_parameters(const std::vector<UpdatingParameter>& parameters, const InferOptions& options,
                    InferenceProblem& problem, IssueList& issues) {
  Named<MarginalPrior> priors;
  for (const auto& parameter : parameters) {
    const MarginalPrior prior = prior_of(parameter, options);
    IssueList improper;
    check(parameter.name, prior, improper);
    for (const auto& issue : improper.issues())
      issues.add({}, "priors: '" + parameter.name + "': " + issue.what, issue.why, issue.fix);
    const auto [lower, upper] = support(prior);
    if (improper.empty() && !(lower <= parameter.initial && parameter.initial <= upper))
      issues.add({}, "priors: that of '" + parameter.name + "' excludes its initial value",
                 "the search for the most probable values starts there", "change one of them");
    problem.parameters.push_back({parameter.name, parameter.unit, parameter.initial});
    priors.emplace_back(parameter.name, prior);
  }
  for (const auto& name : options.profile) {
    const auto found = std::ranges::find(problem.parameters, name, &InferredParameter::name);
    if (found == problem.parameters.end())
      issues.add({}, "profile: there is no parameter '" + name + "'", "", "");
    else
      problem.profile.push_back(static_cast<std::size_t>(found - problem.parameters.begin()));
  }
  issues.raise();
  problem.prior = JointPrior(std::move(priors));
}

/// Degrees of freedom of the finite elements; lumped parts count as a hundred together.
Index dofs_of(const StructureModel& structure) {
  Index dofs = 100;
  for (const auto& elements : structure.finite_elements) dofs += elements.part->full.size();
  return dofs;
}

}  // namespace

InferResult infer(const Structure& structure, const UpdateOptions& comparisons, const InferOptions& options) {
  IssueList issues;
  check_options(options, comparisons, issues);
  issues.raise();
  const auto names = names_of_parameters(comparisons);
  const auto model = make_structure_model(structure.description(), {.parameters = names});
  const Refined found = refined(*model, comparisons);
  require_definite(model, found);
  const auto made = make_comparisons(
      structure, model,
      std::make_shared<const ParameterisedStructure>(model, found.bindings, std::ssize(found.parameters)),
      found.parameters, comparisons);
  const auto residual = std::make_shared<const ResidualSum>(sum_of(made, std::numeric_limits<std::size_t>::max()));
  first_values(*residual, found.parameters);
  InferenceProblem problem;
  set_parameters(found.parameters, options, problem, issues);
  problem.likelihood = LikelihoodKind::comparisons;
  problem.method = options.method;
  problem.samples = options.samples;
  problem.seed = options.seed;
  problem.predictions = 0;
  return result_of(infer(problem, likelihood_of_residual(residual, names, "what is compared", dofs_of(*model)),
                         {.progress = options.progress}));
}

}  // namespace kalfem
