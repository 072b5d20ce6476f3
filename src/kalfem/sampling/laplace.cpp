#include "kalfem/sampling/laplace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/sampling/log_posterior_differences.hpp"

// 1. climb(): BFGS over z from every start. Differences take a twentieth of a deviation by the approximate inverse
//    Hessian, so they follow the width of the posterior, which may be a thousandth of the prior's.
// 2. polish(): Newton steps over theta by ThetaDifferences, and the Hessian at their end.

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A maximum that the search found.
struct Peak {
  Eigen::VectorXd z;
  double value = -infinity;
  Eigen::MatrixXd inverse;  ///< of the negative Hessian over z, approximately
  bool converged = false;
};

/// Backtracks until the rise is a small part of what the slope promises.
bool search_line(LogPosterior& log_posterior, Peak& peak, const Eigen::VectorXd& direction, double slope) {
  for (double length = 1.0; length > 1e-10; length *= 0.5) {
    const Eigen::VectorXd z = peak.z + length * direction;
    const double value = log_posterior.of(z)[0];
    if (!(value >= peak.value + 1e-4 * length * slope)) continue;
    peak.z = z;
    peak.value = value;
    return true;
  }
  return false;
}

Peak climb(LogPosterior& log_posterior, const Eigen::VectorXd& start, const LaplaceOptions& options) {
  Peak peak{.z = start, .value = log_posterior.of(start)[0], .inverse = {}};
  if (!std::isfinite(peak.value)) return peak;
  const auto differences = [&](const Eigen::VectorXd& steps) {
    return Differences(log_posterior.of(cross_points(peak.z, steps)), peak.value, steps);
  };
  const auto steps = [&] {
    return Eigen::VectorXd((0.05 * peak.inverse.diagonal().cwiseSqrt()).cwiseMax(1e-7).cwiseMin(0.02));
  };
  const auto from_curvature = [](const Eigen::VectorXd& curvature) {
    return Eigen::MatrixXd(curvature.cwiseAbs().cwiseMax(1.0).cwiseInverse().asDiagonal());
  };
  const auto size = start.size();
  peak.inverse = from_curvature(differences(Eigen::VectorXd::Constant(size, 1e-3)).curvature);
  Differences now = differences(steps());
  bool fresh = true;  // the inverse is a diagonal one
  for (int k = 0; k < options.max_iterations; ++k) {
    stop_if_asked();
    const Eigen::VectorXd direction = peak.inverse * now.gradient;
    const double slope = now.gradient.dot(direction);
    peak.converged = 0.5 * slope < options.decrement;
    if (peak.converged) break;
    const Eigen::VectorXd before = peak.z;
    if (!search_line(log_posterior, peak, direction, slope)) {
      if (fresh) break;
      peak.inverse = from_curvature(now.curvature);
      fresh = true;
      continue;
    }
    const Differences next = differences(steps());
    const Eigen::VectorXd s = peak.z - before, y = now.gradient - next.gradient;
    fresh = false;
    if (const double sy = s.dot(y); sy > 1e-12 * s.norm() * y.norm()) {
      const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(size, size) - s * y.transpose() / sy;
      peak.inverse = left * peak.inverse * left.transpose() + s * s.transpose() / sy;
    }
    now = next;
  }
  return peak;
}

bool negative_definite(const Eigen::MatrixXd& hessian) {
  if (!hessian.allFinite()) return false;
  const Eigen::VectorXd scale = hessian.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff() <
         -1e-8;
}

/// Newton's method to the end; the Hessian there.
Eigen::MatrixXd polish(ThetaDifferences& differences, const LaplaceOptions& options, bool& converged) {
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

void warn_of_near_bounds(const JointPrior& prior, LaplaceApproximation& result) {
  for (std::size_t i = 0; i < prior.marginals().size(); ++i) {
    const auto& [name, marginal] = prior.marginals()[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(result.covariance(k, k));
    for (const double bound : {support(marginal).lower, support(marginal).upper})
      if (std::abs(result.mode[k] - bound) < 2.0 * deviation)
        result.warnings.push_back(name + ": the bound " + shortest(bound) +
                                  " is within two deviations of the maximum and cuts the posterior; sample");
  }
}

Peak highest_peak(LogPosterior& log_posterior, const LaplaceOptions& options, LaplaceApproximation& result) {
  const Eigen::Index size = log_posterior.prior().size();
  std::vector<Eigen::VectorXd> starts = {options.start ? log_posterior.prior().to_standard_normal(*options.start)
                                                       : Eigen::VectorXd(Eigen::VectorXd::Zero(size))};
  RandomStream random(options.seed, "laplace starts");
  for (int k = 0; k < options.random_starts; ++k) {
    starts.emplace_back(size);
    for (auto& value : starts.back()) value = random.normal();
  }
  Peak highest;
  bool several = false;
  for (const auto& start : starts) {
    Peak peak = climb(log_posterior, start, options);
    if (!std::isfinite(peak.value)) continue;
    if (std::isfinite(highest.value) && peak.converged && highest.converged) {
      const Eigen::VectorXd apart = (peak.z - highest.z).cwiseQuotient(highest.inverse.diagonal().cwiseSqrt());
      several = several || apart.cwiseAbs().maxCoeff() > 1.0;
    }
    if (peak.value > highest.value) highest = std::move(peak);
  }
  if (!std::isfinite(highest.value))
    throw InvalidInput("no start has a likelihood", "the search for the maximum has nowhere to begin",
                       "give a start where the model is possible, or more random starts");
  if (several)
    result.warnings.emplace_back("starts ended on several maxima; the approximation knows only the highest; sample");
  return highest;
}

}  // namespace

LaplaceApproximation laplace_approximation(const Posterior& posterior, const LaplaceOptions& options) {
  if (options.start && options.start->size() != posterior.prior.size())
    throw InvalidInput("the start has " + std::to_string(options.start->size()) + " values",
                       "one for each of the " + std::to_string(posterior.prior.size()) + " parameters",
                       "give one each");
  const JointPrior& prior = posterior.prior;
  LogPosterior log_posterior(posterior, options.threads);
  LaplaceApproximation result;
  const Peak peak = highest_peak(log_posterior, options, result);
  result.converged = peak.converged;
  result.mode = prior.from_standard_normal(peak.z);

  const auto bounds = on_bounds(prior, result.mode);
  result.warnings.insert(result.warnings.end(), bounds.begin(), bounds.end());
  if (bounds.empty()) {
    const Eigen::VectorXd width = 0.1 * peak.inverse.diagonal().cwiseSqrt();
    const Eigen::VectorXd steps = (prior.from_standard_normal(peak.z + width) - result.mode).cwiseAbs();
    ThetaDifferences differences(log_posterior, result.mode, steps);
    const Eigen::MatrixXd hessian = polish(differences, options, result.converged);
    result.mode = differences.theta();
    if (negative_definite(hessian)) {
      const Eigen::LDLT<Eigen::MatrixXd> information(-hessian);
      result.covariance = information.solve(Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols()));
      result.log_evidence = log_posterior.at(result.mode)[0] +
                            0.5 * static_cast<double>(hessian.rows()) * std::log(2.0 * std::numbers::pi) -
                            0.5 * information.vectorD().array().log().sum();
      warn_of_near_bounds(prior, result);
    } else {
      result.warnings.emplace_back(
          "the log-posterior is not curved downwards in every direction: some combination of parameters is not "
          "determined by the data, or the maximum is none; sample, or give a narrower prior");
    }
  }
  if (!result.converged)
    result.warnings.emplace_back("the search did not converge; try another start or more iterations");
  result.log_prior = prior.log_density(result.mode);
  result.log_likelihood = posterior.log_likelihood_at(result.mode);
  result.evaluations = log_posterior.evaluations() + 1;
  return result;
}

}  // namespace kalfem
