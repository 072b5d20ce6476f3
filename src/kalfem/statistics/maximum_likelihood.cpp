// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/maximum_likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kalfem/base/parallel.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double first_radius = 10.0;      ///< of the trust region, in steps of the differences' parameters
constexpr double smallest_radius = 1e-3;   ///< below it the search has come to rest
constexpr double acceptable = 0.1;         ///< part of the predicted rise that a step must bring
constexpr double least_curvature = 1e-12;  ///< relative

using Densities = std::optional<VectorXd>;

/// The log-densities about a point, and the derivatives that follow from them. In units of the parameters' steps.
struct Surroundings {
  double value = 0.0;  ///< sum of the log-densities and of the prior's
  VectorXd gradient;   ///< of it
  MatrixXd curvature;  ///< negative second derivative
  MatrixXd scores;     ///< of the samples, parameters x samples
};

class LikelihoodSearch {
public:
  LikelihoodSearch(const LogDensities& log_densities, const std::vector<LikelihoodParameter>& parameters,
                   const LikelihoodOptions& options)
      : log_densities_(log_densities), parameters_(parameters), options_(options), step_(size()) {
    for (Index i = 0; i < size(); ++i) step_[i] = parameter(i).step;
  }

  // Each iteration plans a Newton step in the trust region. A step that raises the likelihood as far as the quadratic
  // model promises is taken, another one is planned again in a smaller region. The mixed second derivatives cost most:
  // the correlations of the scores stand for them until the search would end.
  std::optional<MaximumLikelihood> run() {
    VectorXd x(size());
    for (Index i = 0; i < size(); ++i) x[i] = parameter(i).start;
    if (size() == 0) return MaximumLikelihood{.estimate = x, .converged = true};
    bool exact = size() == 1;
    auto here = around(x, exact);
    if (!here) return std::nullopt;
    double radius = first_radius;
    bool converged = false;
    for (int iteration = 0; iteration < options_.max_iterations && !converged; ++iteration) {
      const VectorXd step = newton_step(*here, x, radius);
      const double predicted = step.dot(here->gradient) - 0.5 * step.dot(here->curvature * step);
      const bool limited = step.cwiseAbs().maxCoeff() > 0.999 * radius;
      if ((!limited && predicted < options_.decrement) || radius < smallest_radius) {
        if (exact) converged = true;
        if (!std::exchange(exact, true)) here = around(x, exact);
        if (!here) return std::nullopt;
        continue;
      }
      const VectorXd next = x + step.cwiseProduct(step_);
      const auto densities = evaluate({next}).front();
      const double rise = densities ? densities->sum() + log_prior(next) - here->value : -1.0;
      const auto there = rise < acceptable * predicted ? std::nullopt : around(next, exact);
      if (!there) {
        radius = 0.25 * std::min(radius, step.cwiseAbs().maxCoeff());
        continue;
      }
      x = next;
      here = there;
      if (limited && rise > 0.5 * predicted) radius *= 2.0;
    }
    if (!exact) here = around(x, true);
    if (!here) return std::nullopt;
    return result(x, *here, converged);
  }

private:
  [[nodiscard]] Index size() const { return static_cast<Index>(parameters_.size()); }
  [[nodiscard]] const LikelihoodParameter& parameter(Index i) const { return parameters_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] double log_prior(const VectorXd& x) const {
    double sum = 0.0;
    for (Index i = 0; i < size(); ++i) {
      const double e = (x[i] - parameter(i).prior_mean) / parameter(i).prior_deviation;
      sum -= 0.5 * e * e;
    }
    return sum;
  }

  /// The log-densities at several points, side by side.
  std::vector<Densities> evaluate(const std::vector<VectorXd>& points) {
    std::vector<Densities> found(points.size());
    for_each_index(points.size(), options_.threads, [&](std::size_t i) {
      found[i] = log_densities_(points[i]);
      if (found[i] && !std::isfinite(found[i]->sum())) found[i].reset();
    });
    evaluations_ += static_cast<int>(points.size());
    return found;
  }

  // Points 0: x; 1 + 2 i and 2 + 2 i: x +- step i; then, for each pair i < j, both steps forwards and both backwards.
  std::optional<Surroundings> around(const VectorXd& x, bool exact) {
    std::vector<VectorXd> points{x};
    const auto moved = [&](VectorXd from, Index i, double sign) {
      from[i] += sign * step_[i];
      return from;
    };
    for (Index i = 0; i < size(); ++i)
      for (const double sign : {1.0, -1.0}) points.push_back(moved(x, i, sign));
    for (Index i = 0; i < size() && exact; ++i)
      for (Index j = i + 1; j < size(); ++j)
        for (const double sign : {1.0, -1.0}) points.push_back(moved(moved(x, i, sign), j, sign));
    const auto found = evaluate(points);
    if (std::ranges::any_of(found, [](const Densities& densities) { return !densities; })) return std::nullopt;
    return differences(x, found);
  }

  [[nodiscard]] Surroundings differences(const VectorXd& x, const std::vector<Densities>& found) const {
    const Index p = size();
    const auto sum = [&](Index i) { return found[static_cast<std::size_t>(i)]->sum(); };
    Surroundings here{
        .value = sum(0) + log_prior(x), .gradient = VectorXd(p), .curvature = MatrixXd(p, p), .scores = {}};
    here.scores.resize(p, found.front()->size());
    Index pair = 1 + 2 * p;
    for (Index i = 0; i < p; ++i) {
      const auto place = static_cast<std::size_t>(1 + 2 * i);
      here.scores.row(i) = 0.5 * (*found[place] - *found[place + 1]).transpose();
      const double information = std::pow(step_[i] / parameter(i).prior_deviation, 2);
      here.gradient[i] = here.scores.row(i).sum() - information * (x[i] - parameter(i).prior_mean) / step_[i];
      here.curvature(i, i) = 2.0 * sum(0) - sum(1 + 2 * i) - sum(2 + 2 * i) + information;
    }
    const bool exact = std::ssize(found) > 1 + 2 * p;
    const MatrixXd outer = here.scores * here.scores.transpose();
    for (Index i = 0; i < p; ++i)
      for (Index j = i + 1; j < p; ++j, pair += 2)
        here.curvature(i, j) = here.curvature(j, i) =
            exact ? -0.5 * (sum(pair) + sum(pair + 1) + 2.0 * sum(0) - sum(1 + 2 * i) - sum(2 + 2 * i) -
                            sum(1 + 2 * j) - sum(2 + 2 * j))
                  : outer(i, j) * std::sqrt(std::abs(here.curvature(i, i) * here.curvature(j, j)) /
                                            std::max(outer(i, i) * outer(j, j), 1e-300));
    return here;
  }

  /// The step that maximises the quadratic model, each direction by the size of its curvature, cut to the region and to
  /// the bounds.
  [[nodiscard]] VectorXd newton_step(const Surroundings& here, const VectorXd& x, double radius) const {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(here.curvature);
    const VectorXd size_of = solver.eigenvalues().cwiseAbs();
    const VectorXd along = solver.eigenvectors().transpose() * here.gradient;
    VectorXd step =
        solver.eigenvectors() * along.cwiseQuotient(size_of.cwiseMax(least_curvature * size_of.maxCoeff() + 1e-300));
    const double longest = step.cwiseAbs().maxCoeff();
    if (longest > radius) step *= radius / longest;
    for (Index i = 0; i < size(); ++i)
      step[i] =
          std::clamp(x[i] + step[i] * step_[i], parameter(i).lower, parameter(i).upper) / step_[i] - x[i] / step_[i];
    return step;
  }

  [[nodiscard]] MaximumLikelihood result(const VectorXd& x, const Surroundings& here, bool converged) const {
    const MatrixXd scale = step_.asDiagonal();
    VectorXd prior(size());
    for (Index i = 0; i < size(); ++i) prior[i] = std::pow(step_[i] / parameter(i).prior_deviation, 2);
    MaximumLikelihood found{
        .estimate = x, .log_likelihood = here.value, .converged = converged, .evaluations = evaluations_};
    found.robust = robust_covariance(here.curvature, MatrixXd(prior.asDiagonal()), here.scores);
    found.covariance = scale * sandwich(here.curvature, here.curvature).covariance * scale;
    found.robust.covariance = scale * found.robust.covariance * scale;
    return found;
  }

  const LogDensities& log_densities_;
  const std::vector<LikelihoodParameter>& parameters_;
  LikelihoodOptions options_;
  VectorXd step_;
  int evaluations_ = 0;
};

}  // namespace

std::optional<MaximumLikelihood> maximise_likelihood(const LogDensities& log_densities,
                                                     const std::vector<LikelihoodParameter>& parameters,
                                                     const LikelihoodOptions& options) {
  return LikelihoodSearch(log_densities, parameters, options).run();
}

}  // namespace kalfem
