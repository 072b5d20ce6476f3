// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/posterior_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::VectorXd;

namespace {

std::optional<double> found(const std::string& name, const RecordEstimate& estimate) {
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  const auto of_filter = std::ranges::find(unknowns, name, &UnknownParameter::name);
  if (of_filter != unknowns.end()) return estimate.result.unknowns.mean(of_filter - unknowns.begin(), Eigen::last);
  if (!estimate.likelihood) return std::nullopt;
  const auto& searched = estimate.likelihood->unknowns;
  const auto by_search = std::ranges::find(searched, name, &LikelihoodUnknown::name);
  if (by_search == searched.end()) return std::nullopt;
  return estimate.likelihood->values[by_search - searched.begin()];
}

/// The filter's values inside the priors, the problem's others; nothing without an estimate, or where the filter
/// stopped.
std::optional<VectorXd> filter_start(const InferenceProblem& problem, const RecordEstimate* estimate) {
  if (!estimate || estimate->result.failure) return std::nullopt;
  VectorXd start = start_of(problem);
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const auto value = found(problem.parameters[i].name, *estimate);
    const auto [lower, upper] = support(problem.prior.marginals()[i].second);
    if (value && std::isfinite(*value) && lower < *value && *value < upper)
      start[static_cast<Eigen::Index>(i)] = *value;
  }
  return start;
}

/// ln p(data | theta) p(theta) at the start.
double density(const PosteriorSearch& search, const JointPrior& prior) {
  const double value = search.likelihood.log_likelihood(search.start) + prior.log_density(search.start);
  return std::isfinite(value) ? value : -std::numeric_limits<double>::infinity();
}

}  // namespace

PosteriorSearch begin_search(const InferenceProblem& problem, const Record& record, const RecordEstimate* estimate) {
  const auto from = [&](const VectorXd& start) {
    return PosteriorSearch{likelihood_of_record(problem, record, start), start};
  };
  if (const auto start = filter_start(problem, estimate)) try {
      PosteriorSearch found = from(*start);
      const double here = density(found, problem.prior);
      if (here > density({found.likelihood, start_of(problem)}, problem.prior)) return found;
    } catch (const InvalidInput&) {  // the filter's values make no structure
    }
  return from(start_of(problem));
}

}  // namespace kalfem
