#include "kalfem/sampling/laplace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"

// 1. climb(): BFGS over z from every start. Differences take a twentieth of a deviation by the approximate inverse
//    Hessian, so they follow the width of the posterior, which may be a thousandth of the prior's.
// 2. ThetaDifferences: steps of each parameter over which the log-posterior falls by 0.01: the quadratic term is then
// far
//    above rounding, even of a log-likelihood of -1e6, and the quartic one far below the quadratic.
// 3. polish(): Newton steps over theta by these differences, and the Hessian at their end.

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// ln p(data | theta) p(theta), evaluated side by side and counted.
class Objective {
public:
  Objective(const Posterior& posterior, int threads) : posterior_(posterior), threads_(threads) {}

  [[nodiscard]] const JointPrior& prior() const { return posterior_.prior; }
  [[nodiscard]] int evaluations() const { return evaluations_; }

  /// At the columns of theta.
  Eigen::VectorXd at(const Eigen::MatrixXd& theta) {
    Eigen::VectorXd values(theta.cols());
    evaluations_ += static_cast<int>(theta.cols());
    for_each_index(static_cast<std::size_t>(theta.cols()), threads_, [&](std::size_t k) {
      stop_if_asked();
      const auto i = static_cast<Eigen::Index>(k);
      const double log_prior = prior().log_density(theta.col(i));
      values[i] = std::isfinite(log_prior) ? log_prior + posterior_.log_likelihood_at(theta.col(i)) : -infinity;
    });
    return values;
  }
  /// At the columns of z, the standard normals.
  Eigen::VectorXd of(const Eigen::MatrixXd& z) {
    Eigen::MatrixXd theta(z.rows(), z.cols());
    for (Eigen::Index k = 0; k < z.cols(); ++k) theta.col(k) = prior().from_standard_normal(z.col(k));
    return at(theta);
  }

private:
  const Posterior& posterior_;
  int threads_;
  int evaluations_ = 0;
};

/// x + h_i e_i in the columns 2 i, x - h_i e_i in 2 i + 1.
Eigen::MatrixXd cross_points(const Eigen::VectorXd& x, const Eigen::VectorXd& steps) {
  Eigen::MatrixXd points = x.replicate(1, 2 * x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    points(i, 2 * i) += steps[i];
    points(i, 2 * i + 1) -= steps[i];
  }
  return points;
}

/// First and second differences; one-sided beside an impossible point.
struct Differences {
  Eigen::VectorXd gradient, curvature;

  Differences(const Eigen::VectorXd& values, double centre, const Eigen::VectorXd& steps)
      : gradient(Eigen::VectorXd::Zero(steps.size())), curvature(Eigen::VectorXd::Zero(steps.size())) {
    for (Eigen::Index i = 0; i < steps.size(); ++i) {
      const double up = values[2 * i], down = values[2 * i + 1], h = steps[i];
      if (std::isfinite(up) && std::isfinite(down)) {
        gradient[i] = (up - down) / (2.0 * h);
        curvature[i] = (up - 2.0 * centre + down) / (h * h);
      } else if (std::isfinite(up) || std::isfinite(down)) {
        gradient[i] = std::isfinite(up) ? (up - centre) / h : (centre - down) / h;
      }
    }
  }
};

/// A maximum that the search found.
struct Peak {
  Eigen::VectorXd z;
  double value = -infinity;
  Eigen::MatrixXd inverse;  ///< of the negative Hessian over z, approximately
  bool converged = false;
};

/// Backtracks until the rise is a small part of what the slope promises.
bool search_line(Objective& objective, Peak& peak, const Eigen::VectorXd& direction, double slope) {
  for (double length = 1.0; length > 1e-10; length *= 0.5) {
    const Eigen::VectorXd z = peak.z + length * direction;
    const double value = objective.of(z)[0];
    if (!(value >= peak.value + 1e-4 * length * slope)) continue;
    peak.z = z;
    peak.value = value;
    return true;
  }
  return false;
}

Peak climb(Objective& objective, const Eigen::VectorXd& start, const LaplaceOptions& options) {
  Peak peak{.z = start, .value = objective.of(start)[0], .inverse = {}};
  if (!std::isfinite(peak.value)) return peak;
  const auto differences = [&](const Eigen::VectorXd& steps) {
    return Differences(objective.of(cross_points(peak.z, steps)), peak.value, steps);
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
    if (!search_line(objective, peak, direction, slope)) {
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

/// Differences over theta with good steps.
class ThetaDifferences {
public:
  ThetaDifferences(Objective& objective, const Eigen::VectorXd& theta, const Eigen::VectorXd& first_steps)
      : objective_(objective), theta_(theta), value_(objective.at(theta)[0]), steps_(first_steps) {
    constexpr double wanted_fall = 0.01;
    for (int k = 0; k < 4; ++k) {
      keep_inside();
      const Eigen::VectorXd values = objective_.at(cross_points(theta_, steps_));
      for (Eigen::Index i = 0; i < steps_.size(); ++i) {
        const double fall = value_ - 0.5 * (values[2 * i] + values[2 * i + 1]);
        steps_[i] *= std::clamp(std::sqrt(wanted_fall / std::max(fall, 1e-300)), 0.1, 10.0);
      }
    }
    keep_inside();
  }

  [[nodiscard]] const Eigen::VectorXd& theta() const { return theta_; }

  Eigen::VectorXd gradient() {
    return Differences(objective_.at(cross_points(theta_, steps_)), value_, steps_).gradient;
  }

  Eigen::MatrixXd hessian() {
    const Eigen::Index size = theta_.size();
    Eigen::MatrixXd hessian =
        Differences(objective_.at(cross_points(theta_, steps_)), value_, steps_).curvature.asDiagonal();
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index j = 0; j < i; ++j) {
        Eigen::MatrixXd points = theta_.replicate(1, 4);
        points.row(i) += steps_[i] * Eigen::RowVector4d(1, 1, -1, -1);
        points.row(j) += steps_[j] * Eigen::RowVector4d(1, -1, 1, -1);
        const Eigen::VectorXd values = objective_.at(points);
        hessian(i, j) = (values[0] - values[1] - values[2] + values[3]) / (4.0 * steps_[i] * steps_[j]);
        hessian(j, i) = hessian(i, j);
      }
    return hessian;
  }

  /// Goes there unless the log-posterior is lower; halves the step three times before it gives up.
  bool go(Eigen::VectorXd step) {
    for (int k = 0; k < 4; ++k, step *= 0.5) {
      const double value = objective_.at(theta_ + step)[0];
      if (!(value >= value_)) continue;
      theta_ += step;
      value_ = value;
      return true;
    }
    return false;
  }

private:
  void keep_inside() {
    for (Eigen::Index i = 0; i < steps_.size(); ++i) {
      const auto [lower, upper] = support(objective_.prior().marginals()[static_cast<std::size_t>(i)].second);
      const double room = std::min(theta_[i] - lower, upper - theta_[i]);
      steps_[i] = std::max(std::min(steps_[i], 0.5 * room), 1e-13 * std::max(std::abs(theta_[i]), 1e-280));
    }
  }

  Objective& objective_;
  Eigen::VectorXd theta_;
  double value_;
  Eigen::VectorXd steps_;
};

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

Peak highest_peak(Objective& objective, const LaplaceOptions& options, LaplaceApproximation& result) {
  const Eigen::Index size = objective.prior().size();
  std::vector<Eigen::VectorXd> starts = {options.start ? objective.prior().to_standard_normal(*options.start)
                                                       : Eigen::VectorXd(Eigen::VectorXd::Zero(size))};
  RandomStream random(options.seed, "laplace starts");
  for (int k = 0; k < options.random_starts; ++k) {
    starts.emplace_back(size);
    for (auto& value : starts.back()) value = random.normal();
  }
  Peak highest;
  bool several = false;
  for (const auto& start : starts) {
    Peak peak = climb(objective, start, options);
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
  Objective objective(posterior, options.threads);
  LaplaceApproximation result;
  const Peak peak = highest_peak(objective, options, result);
  result.converged = peak.converged;
  result.mode = prior.from_standard_normal(peak.z);

  const auto bounds = on_bounds(prior, result.mode);
  result.warnings.insert(result.warnings.end(), bounds.begin(), bounds.end());
  if (bounds.empty()) {
    const Eigen::VectorXd width = 0.1 * peak.inverse.diagonal().cwiseSqrt();
    const Eigen::VectorXd steps = (prior.from_standard_normal(peak.z + width) - result.mode).cwiseAbs();
    ThetaDifferences differences(objective, result.mode, steps);
    const Eigen::MatrixXd hessian = polish(differences, options, result.converged);
    result.mode = differences.theta();
    if (negative_definite(hessian)) {
      const Eigen::LDLT<Eigen::MatrixXd> information(-hessian);
      result.covariance = information.solve(Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols()));
      result.log_evidence = objective.at(result.mode)[0] +
                            0.5 * static_cast<double>(hessian.rows()) * std::log(2.0 * std::numbers::pi) -
                            0.5 * information.vectorD().array().log().sum();
      warn_of_near_bounds(prior, result);
    } else {
      result.warnings.emplace_back(
          "the log-posterior is not curved downwards in every direction: some combination of parameters is not "
          "determined by "
          "the data, or the maximum is none; sample, or give a narrower prior");
    }
  }
  if (!result.converged)
    result.warnings.emplace_back("the search did not converge; try another start or more iterations");
  result.log_prior = prior.log_density(result.mode);
  result.log_likelihood = posterior.log_likelihood_at(result.mode);
  result.evaluations = objective.evaluations() + 1;
  return result;
}

}  // namespace kalfem
