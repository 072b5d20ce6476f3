#include "kalfem/pipeline/search_start.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/pipeline/case_likelihood.hpp"

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

}  // namespace

VectorXd search_start(const InferencePlan& plan, const RecordEstimate* estimate) {
  VectorXd start = start_of(plan);
  if (!estimate || estimate->result.failure) return start;
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    const auto value = found(plan.parameters[i].name, *estimate);
    const auto [lower, upper] = support(plan.prior.marginals()[i].second);
    if (value && std::isfinite(*value) && lower < *value && *value < upper)
      start[static_cast<Eigen::Index>(i)] = *value;
  }
  return start;
}

}  // namespace kalfem
