// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/filter_posterior.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/inference/sample_posterior.hpp"
#include "kalfem/sampling/log_posterior_differences.hpp"
#include "kalfem/sampling/peak_search.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double strong_evidence = 3.0;  ///< difference of ln Z that Kass and Raftery (1995) call strong

/// The filter's distribution of the problem's parameters at the record's end.
struct FinalDistribution {
  std::vector<ParameterTransform> transforms;
  VectorXd mean;        ///< x, in the filter's coordinates
  MatrixXd covariance;  ///< of x

  [[nodiscard]] VectorXd parameters(const VectorXd& x) const {
    VectorXd theta(x.size());
    for (Index i = 0; i < x.size(); ++i) theta[i] = transforms[static_cast<std::size_t>(i)].to_parameter(x[i]);
    return theta;
  }
};

FinalDistribution final_distribution(const InferenceProblem& problem, const RecordEstimate& estimate) {
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  FinalDistribution final;
  std::vector<Index> rows;
  for (const auto& parameter : problem.parameters) {
    const auto unknown = std::ranges::find(unknowns, parameter.name, &UnknownParameter::name);
    final.transforms.push_back(unknown->transform);
    rows.push_back(estimate.augmented_model->layout().unknown() + (unknown - unknowns.begin()));
  }
  final.mean = estimate.result.state.mean.col(estimate.result.state.mean.cols() - 1)(rows);
  final.covariance = estimate.result.final_covariance(rows, rows);
  return final;
}

/// L of the covariance L L^T.
MatrixXd root_of(const MatrixXd& covariance) {
  const Eigen::LDLT<MatrixXd> factor(covariance);
  return factor.transpositionsP().transpose() * MatrixXd(factor.matrixL()) *
         factor.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

SampleSet samples_of(const FinalDistribution& final, const InferenceProblem& problem, double log_likelihood) {
  const MatrixXd root = root_of(final.covariance);
  MatrixXd z(final.mean.size(), problem.samples);
  RandomStream random(problem.seed, "filter's posterior");
  for (auto column : z.colwise()) {
    const VectorXd normal = VectorXd::NullaryExpr(z.rows(), [&] { return random.normal(); });
    column = problem.prior.to_standard_normal(final.parameters(final.mean + root * normal));
  }
  return make_sample_set(problem.prior, z, VectorXd::Constant(problem.samples, log_likelihood), 1);
}

/// Of a normal distribution about the estimate, over the standard normals z of the prior, P_z the filter's covariance:
///     ln Z = ln p(data | theta) - |z|^2 / 2 + 1/2 ln det P_z.
double evidence_about_estimate(const FinalDistribution& final, const JointPrior& prior, double log_likelihood) {
  const VectorXd step = 0.01 * final.covariance.diagonal().cwiseSqrt();
  const auto z = [&](const VectorXd& x) { return prior.to_standard_normal(final.parameters(x)); };
  const VectorXd slope = (z(final.mean + step) - z(final.mean - step)).cwiseQuotient(2.0 * step);
  const MatrixXd covariance = slope.asDiagonal() * final.covariance * slope.asDiagonal();
  return log_likelihood - 0.5 * z(final.mean).squaredNorm() +
         0.5 * Eigen::LDLT<MatrixXd>(covariance).vectorD().array().log().sum();
}

/// How far the likelihood's maximum lies from the filter's estimate.
struct MaximumBeside {
  VectorXd shift;       ///< of each parameter, in the smaller one of the filter's and the likelihood's deviations
  VectorXd parameters;  ///< theta there
  int evaluations = 0;
};

/// A few steps of a search over u, x = m + L u, where a right filter's posterior is N(0, I): it then ends where it
/// began.
MaximumBeside maximum_beside(const FinalDistribution& final, const Posterior& posterior, int threads) {
  constexpr int few_steps = 3;
  constexpr double small_rise = 0.125;  ///< of half a deviation
  const MatrixXd root = root_of(final.covariance);
  LogPosterior log_posterior(posterior, threads);
  const auto over_u = [&](const MatrixXd& u) {
    MatrixXd z(u.rows(), u.cols());
    for (Index k = 0; k < u.cols(); ++k)
      z.col(k) = posterior.prior.to_standard_normal(final.parameters(final.mean + root * u.col(k)));
    return log_posterior.over_normals(z);
  };
  const Peak peak =
      climb(over_u, VectorXd::Zero(final.mean.size()), {.max_iterations = few_steps, .decrement = small_rise});
  const VectorXd shift = root * peak.z;
  const VectorXd variance = (root * peak.inverse * root.transpose()).diagonal();
  return {shift.cwiseQuotient(variance.cwiseMin(final.covariance.diagonal()).cwiseSqrt()),
          final.parameters(final.mean + shift), log_posterior.evaluations()};
}

/// Warns where it is a deviation or more.
void compare_with_likelihood(const InferenceProblem& problem, const FinalDistribution& final,
                             const Posterior& posterior, int threads, InferenceResult& result) {
  constexpr double far = 1.0;
  const auto [shift, parameters, evaluations] = maximum_beside(final, posterior, threads);
  result.evaluations += evaluations;
  std::string words;
  for (Index i = 0; i < shift.size(); ++i) {
    if (!(std::abs(shift[i]) >= far)) continue;
    const auto& parameter = problem.parameters[static_cast<std::size_t>(i)];
    words += fmt::format("{}'{}' by {:.1f} standard deviations (filter {:.4g}, likelihood {:.4g} {})",
                         words.empty() ? "" : ", ", parameter.name, shift[i], result.most_probable[i], parameters[i],
                         parameter.unit);
  }
  if (words.empty()) return;
  result.warnings.push_back(
      "the filter's values at the record's end are not those that the likelihood of the record "
      "finds most probable, which differ for " +
      words + "; start the unknowns nearer to their values, or take method: importance");
}

}  // namespace

void take_filter_posterior(const InferenceProblem& problem, const Record& record, const RecordEstimate& estimate,
                           const ParameterLikelihood& likelihood, InferenceResult& result) {
  if (estimate.result.failure)
    throw InvalidInput(Issue{problem.location, "infer: " + estimate.failure(),
                             "method: filter takes the posterior that it has at the record's end",
                             "change the model or its noise, or take method: importance"});
  const FinalDistribution final = final_distribution(problem, estimate);
  result.method = "normal distribution of the filter at the record's end";
  result.most_probable = final.parameters(final.mean);
  result.log_likelihood = likelihood.log_likelihood(result.most_probable);
  result.samples = samples_of(final, problem, result.log_likelihood);
  result.log_evidence = evidence_about_estimate(final, problem.prior, result.log_likelihood);
  const double of_one_pass = FilterLikelihood(problem.problem, record, {}).log_likelihood(VectorXd());
  result.log_evidence_deviation = std::abs(*result.log_evidence - of_one_pass);
  result.evaluations = 2;
  compare_with_likelihood(problem, final, {problem.prior, likelihood.log_likelihood}, problem.threads(), result);
  if (!(*result.log_evidence_deviation < strong_evidence))
    result.warnings.push_back(fmt::format(
        "ln Z about the filter's estimate and ln p of its whole pass, which would be the same if the filter were "
        "exact, are {:.3g} apart: smaller differences between laws say nothing; start the unknowns nearer to their "
        "values, or "
        "take method: importance",
        *result.log_evidence_deviation));
  summarise_posterior(result);
}

std::vector<FilterComparison> beside_filter(const InferenceResult& result, const RecordEstimate& estimate) {
  std::vector<FilterComparison> all;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (const auto& posterior : result.posterior) {
    FilterComparison comparison{.name = posterior.name};
    const auto found = std::ranges::find(unknowns, posterior.name, &UnknownParameter::name);
    if (found != unknowns.end()) {
      const Index row = found - unknowns.begin();
      comparison.filter_mean = estimate.result.unknowns.mean(row, Eigen::last);
      comparison.filter_deviation = estimate.result.unknowns.deviation(row, Eigen::last);
    } else if (estimate.likelihood) {
      const auto& searched = estimate.likelihood->unknowns;
      const auto place = std::ranges::find(searched, posterior.name, &LikelihoodUnknown::name);
      if (place == searched.end()) continue;
      comparison.filter_mean = estimate.likelihood->values[place - searched.begin()];
      comparison.filter_deviation = estimate.likelihood->deviation[place - searched.begin()];
    } else {
      continue;
    }
    comparison.mean_difference = (posterior.mean - comparison.filter_mean) / posterior.deviation;
    comparison.deviation_ratio = comparison.filter_deviation / posterior.deviation;
    all.push_back(comparison);
  }
  return all;
}

}  // namespace kalfem
