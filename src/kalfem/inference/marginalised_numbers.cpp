// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/marginalised_numbers.hpp"

#include <algorithm>

#include "kalfem/identification/stated_unknowns.hpp"
#include "kalfem/identification/unknown_prior.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

bool is_of_finite_elements(const Unknown& unknown) {
  return std::ranges::any_of(unknown.targets, [](const Parameter& target) {
    return std::holds_alternative<FiniteElementParameter>(target.where);
  });
}

/// Whether the filter can integrate the numbers of the structure out: it sets a linear part that is named as a whole.
bool filter_integrates(const InferenceProblem& problem, const EstimationProblem& with) {
  return problem.likelihood == LikelihoodKind::filter &&
         (problem.method == PosteriorMethod::filter ||
          std::ranges::none_of(with.settings.unknowns, is_of_finite_elements));
}

/// Independent of the others.
MatrixXd widened(const MatrixXd& correlation, Index size) {
  if (correlation.size() == 0) return {};
  MatrixXd wide = MatrixXd::Identity(size, size);
  wide.topLeftCorner(correlation.rows(), correlation.cols()) = correlation;
  return wide;
}

void refuse(const std::vector<std::string>& names, const InferenceProblem& problem, const std::string& why,
            const std::string& fix, IssueList& issues) {
  if (names.empty()) return;
  const auto& known_to = problem.problem->settings.known_to;
  issues.add(known_to.empty() ? problem.location : known_to.front().location,
             "known_to: it states how well '" + names.front() + "' is known", why, fix);
}

}  // namespace

void marginalise_stated_numbers(InferenceProblem& problem, IssueList& issues) {
  if (!problem.problem || problem.problem->settings.known_to.empty()) return;
  const StatedUnknowns stated = with_stated_unknowns(problem.problem, problem.setup);
  refuse(stated.of_excitations, problem, "a posterior does not integrate out gains and delays of excitations",
         "state gains of the sensors instead, or leave it out", issues);
  if (problem.method == PosteriorMethod::filter)
    refuse(stated.of_measurement, problem, "it is not in the state of a filter, whose posterior is asked for",
           "take method: importance, or leave it out", issues);
  if (!issues.empty()) return;
  auto priors = problem.prior.marginals();
  const auto sample = [&](const auto& unknown, const std::string& unit) {
    priors.emplace_back(unknown.name, prior_of(unknown));
    problem.parameters.push_back({unknown.name, unit, unknown.initial});
    ++problem.marginalised;
  };
  const auto& settings = stated.problem->settings;
  if (!filter_integrates(problem, *stated.problem))
    for (const auto& name : stated.of_structure) {
      const auto& unknown = *std::ranges::find(settings.unknowns, name, &Unknown::name);
      sample(unknown, unknown.unit());
    }
  for (const auto& name : stated.of_measurement) {
    const auto& unknown = *std::ranges::find(settings.likelihood_unknowns, name, &LikelihoodUnknown::name);
    sample(unknown, unknown.unit);
  }
  problem.prior = JointPrior(priors, widened(problem.prior.correlation(), std::ssize(priors)));
  problem.setup =
      make_augmented_model_setup(*stated.problem, *problem.setup.parts, problem.setup.linear_unknowns.present, issues);
  problem.problem = stated.problem;
}

void drop_marginalised(std::size_t count, InferenceResult& result) {
  if (count == 0) return;
  const auto kept = result.units.size() - count;
  const auto rows = static_cast<Index>(kept);
  const auto cut = [&](auto& list) {
    if (list.size() > kept) list.erase(list.begin() + static_cast<std::ptrdiff_t>(kept), list.end());
  };
  const auto shorten = [&](VectorXd& values) {
    if (values.size() > rows) values.conservativeResize(rows);
  };
  std::vector<std::string> dropped;
  for (std::size_t i = kept; i < result.prior.size(); ++i) dropped.push_back(result.prior[i].name);
  cut(result.units);
  cut(result.truths);
  cut(result.prior);
  cut(result.posterior);
  cut(result.prior_marginals);
  cut(result.convergence);
  cut(result.samples.names);
  if (result.samples.values.rows() > rows) result.samples.values.conservativeResize(rows, Eigen::NoChange);
  if (result.correlation.rows() > rows) result.correlation.conservativeResize(rows, rows);
  shorten(result.most_probable);
  for (auto& mode : result.modes) {
    shorten(mode.peak);
    shorten(mode.mean);
    shorten(mode.deviation);
  }
  std::erase_if(result.beside_filter,
                [&](const FilterComparison& each) { return std::ranges::find(dropped, each.name) != dropped.end(); });
}

}  // namespace kalfem
