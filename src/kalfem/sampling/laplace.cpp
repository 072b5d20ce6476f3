// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/laplace.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "kalfem/base/units.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/sampling/log_posterior_differences.hpp"
#include "kalfem/sampling/peak_search.hpp"

// 1. find_peaks(): BFGS over z from every start.
// 2. approximate() each: Newton steps over theta by LocalDifferences, and the Hessian at their end.

namespace kalfem {
namespace {

bool negative_definite(const Eigen::MatrixXd& hessian) {
  if (!hessian.allFinite()) return false;
  const Eigen::VectorXd scale = hessian.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff() <
         -1e-8;
}

/// Newton's method to the end; the Hessian there.
Eigen::MatrixXd polish(LocalDifferences& differences, const LaplaceOptions& options, bool& converged) {
  Eigen::MatrixXd hessian = differences.hessian();
  for (int k = 0; k < 5 && negative_definite(hessian); ++k) {
    const Eigen::VectorXd gradient = differences.gradient();
    const Eigen::VectorXd step = (-hessian).ldlt().solve(gradient);
    converged = 0.5 * gradient.dot(step) < std::max(1e-4, options.decrement);
    if (0.5 * gradient.dot(step) < options.decrement || !differences.go(step)) break;
    hessian = differences.hessian();
  }
  return hessian;
}

/// The parameters whose maximum lies on a bound at which the prior has density.
std::vector<std::string> on_bounds(const JointPrior& prior, const Eigen::VectorXd& theta) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < prior.marginals().size(); ++i) {
    const auto& [name, marginal] = prior.marginals()[i];
    const double w = to_normal(marginal, theta[static_cast<Eigen::Index>(i)]);
    const double bound = w < 0.0 ? support(marginal).lower : support(marginal).upper;
    if (std::abs(w) > 4.0 && std::isfinite(bound) && std::isfinite(log_density(marginal, bound)))
      found.push_back(name + ": the maximum lies on the bound " + shortest(bound) +
                      ", where the posterior is no normal distribution; widen the prior or sample");
  }
  return found;
}

void warn_of_near_bounds(const JointPrior& prior, const LaplaceMode& result, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < prior.marginals().size(); ++i) {
    const auto& [name, marginal] = prior.marginals()[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(result.covariance(k, k));
    for (const double bound : {support(marginal).lower, support(marginal).upper})
      if (std::abs(result.mode[k] - bound) < 2.0 * deviation)
        warnings.push_back(name + ": the bound " + shortest(bound) +
                           " is within two deviations of the maximum and cuts the posterior; sample");
  }
}

LocalDifferences differences_about(LogPosterior& log_posterior, const Peak& peak) {
  const JointPrior& prior = log_posterior.prior();
  const Eigen::VectorXd theta = prior.from_standard_normal(peak.z);
  const Eigen::VectorXd width = 0.1 * peak.inverse.diagonal().cwiseSqrt();
  Eigen::VectorXd lower(theta.size()), upper(theta.size());
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const auto bounds = support(prior.marginals()[static_cast<std::size_t>(i)].second);
    lower[i] = bounds.lower;
    upper[i] = bounds.upper;
  }
  return {[&log_posterior](const Eigen::MatrixXd& points) { return log_posterior.at(points); }, theta,
          (prior.from_standard_normal(peak.z + width) - theta).cwiseAbs(), lower, upper};
}

/// The normal distribution about a peak, and what speaks against it.
LaplaceMode approximate(const Posterior& posterior, LogPosterior& log_posterior, const Peak& peak,
                        const LaplaceOptions& options, bool& converged, std::vector<std::string>& warnings) {
  const JointPrior& prior = posterior.prior;
  LaplaceMode result{.mode = prior.from_standard_normal(peak.z)};
  converged = peak.converged;
  const auto bounds = on_bounds(prior, result.mode);
  warnings.insert(warnings.end(), bounds.begin(), bounds.end());
  if (bounds.empty()) {
    LocalDifferences differences = differences_about(log_posterior, peak);
    const Eigen::MatrixXd hessian = polish(differences, options, converged);
    result.mode = differences.point();
    if (negative_definite(hessian)) {
      const Eigen::LDLT<Eigen::MatrixXd> information(-hessian);
      result.covariance = information.solve(Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols()));
      result.log_evidence = log_posterior.at(result.mode)[0] +
                            0.5 * static_cast<double>(hessian.rows()) * std::log(2.0 * std::numbers::pi) -
                            0.5 * information.vectorD().array().log().sum();
      warn_of_near_bounds(prior, result, warnings);
    } else {
      warnings.emplace_back(
          "the log-posterior is not curved downwards in every direction: some combination of parameters is not "
          "determined by the data, or the maximum is none; sample, or give a narrower prior");
    }
  }
  if (!converged) warnings.emplace_back("the search did not converge; try another start or more iterations");
  result.log_prior = prior.log_density(result.mode);
  result.log_likelihood = posterior.log_likelihood_at(result.mode);
  return result;
}

}  // namespace

std::optional<double> LaplaceApproximation::log_evidence_of_all() const {
  if (!log_evidence) return std::nullopt;
  Eigen::VectorXd all(1 + std::ssize(others));
  all[0] = *log_evidence;
  for (Eigen::Index k = 1; k < all.size(); ++k) all[k] = *others[static_cast<std::size_t>(k - 1)].log_evidence;
  return log_sum_exp(all);
}

LaplaceApproximation laplace_approximation(const Posterior& posterior, const LaplaceOptions& options) {
  LogPosterior log_posterior(posterior, options.threads);
  const auto log_density = [&](const Eigen::MatrixXd& z) { return log_posterior.of(z); };
  const PeakSearch search = find_peaks(log_density, posterior.prior, options);
  LaplaceApproximation result;
  static_cast<LaplaceMode&>(result) =
      approximate(posterior, log_posterior, search.peaks.front(), options, result.converged, result.warnings);
  for (std::size_t k = 1; k < search.peaks.size(); ++k) {
    if (!search.peaks[k].converged) continue;
    bool converged = false;
    std::vector<std::string> warnings;
    LaplaceMode other = approximate(posterior, log_posterior, search.peaks[k], options, converged, warnings);
    if (other.log_evidence) {
      result.others.push_back(std::move(other));
      result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    } else {
      result.warnings.emplace_back("another maximum has no normal approximation; sample");
    }
  }
  std::ranges::stable_sort(result.others, std::greater(), [](const LaplaceMode& other) { return *other.log_evidence; });
  result.prior_starts = search.prior_starts;
  result.evaluations = log_posterior.evaluations() + 1 + static_cast<int>(result.others.size());
  return result;
}

}  // namespace kalfem
