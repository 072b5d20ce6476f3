// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>

#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// ln p(data | theta) p(theta), evaluated side by side and counted.
class LogPosterior {
public:
  LogPosterior(const Posterior& posterior, int threads) : posterior_(posterior), threads_(threads) {}

  [[nodiscard]] const JointPrior& prior() const { return posterior_.prior; }
  [[nodiscard]] int evaluations() const { return evaluations_; }

  /// At the columns of theta, p x n; -infinity where the model is impossible.
  Eigen::VectorXd at(const Eigen::MatrixXd& theta);
  /// At the columns of z, the standard normals of the prior, p x n.
  Eigen::VectorXd of(const Eigen::MatrixXd& z);
  /// The density over z instead of theta, ln p(data | theta) - z^T z / 2 - p / 2 ln 2 pi, at the columns of z, p x n.
  Eigen::VectorXd over_normals(const Eigen::MatrixXd& z);

private:
  const Posterior& posterior_;
  int threads_;
  int evaluations_ = 0;
};

/// A log-density at the columns of a matrix, p x n; -infinity where the model is impossible.
using LogDensity = std::function<Eigen::VectorXd(const Eigen::MatrixXd& points)>;

/// x + h_i e_i in the columns 2 i, x - h_i e_i in 2 i + 1: p x 2 p.
Eigen::MatrixXd cross_points(const Eigen::VectorXd& x, const Eigen::VectorXd& steps);

/// First and second differences; one-sided beside an impossible point.
struct Differences {
  Eigen::VectorXd gradient, curvature;

  /// `values`: at the cross_points().
  Differences(const Eigen::VectorXd& values, double centre, const Eigen::VectorXd& steps);
};

/// Gradient and Hessian of a log-density by central differences, with steps of each coordinate over which it falls by
/// 0.01: the quadratic term is then far above rounding, even of a log-likelihood of -1e6, and the quartic one far below
/// the quadratic.
class LocalDifferences {
public:
  /// Steps are sought from `first_steps` and stay between `lower` and `upper`, which may be infinite.
  LocalDifferences(LogDensity log_density, const Eigen::VectorXd& point, const Eigen::VectorXd& first_steps,
                   const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

  [[nodiscard]] const Eigen::VectorXd& point() const { return point_; }
  Eigen::VectorXd gradient();
  Eigen::MatrixXd hessian();
  /// Goes there unless the log-density is lower; halves the step three times before it gives up.
  bool go(Eigen::VectorXd step);

private:
  void keep_inside();

  LogDensity log_density_;
  Eigen::VectorXd point_;
  double value_;
  Eigen::VectorXd steps_, lower_, upper_;
};

}  // namespace kalfem
