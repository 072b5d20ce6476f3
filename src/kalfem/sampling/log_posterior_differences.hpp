#pragma once

#include <Eigen/Dense>
#include <limits>

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

private:
  const Posterior& posterior_;
  int threads_;
  int evaluations_ = 0;
};

/// x + h_i e_i in the columns 2 i, x - h_i e_i in 2 i + 1: p x 2 p.
Eigen::MatrixXd cross_points(const Eigen::VectorXd& x, const Eigen::VectorXd& steps);

/// First and second differences; one-sided beside an impossible point.
struct Differences {
  Eigen::VectorXd gradient, curvature;

  /// `values`: at the cross_points().
  Differences(const Eigen::VectorXd& values, double centre, const Eigen::VectorXd& steps);
};

/// Gradient and Hessian of the log-posterior over theta by central differences, with steps of each parameter over which
/// it falls by 0.01: the quadratic term is then far above rounding, even of a log-likelihood of -1e6, and the quartic
/// one far below the quadratic.
class ThetaDifferences {
public:
  /// `first_steps`: from which the steps are sought.
  ThetaDifferences(LogPosterior& log_posterior, const Eigen::VectorXd& theta, const Eigen::VectorXd& first_steps);

  [[nodiscard]] const Eigen::VectorXd& theta() const { return theta_; }
  Eigen::VectorXd gradient();
  Eigen::MatrixXd hessian();
  /// Goes there unless the log-posterior is lower; halves the step three times before it gives up.
  bool go(Eigen::VectorXd step);

private:
  void keep_inside();

  LogPosterior& log_posterior_;
  Eigen::VectorXd theta_;
  double value_;
  Eigen::VectorXd steps_;
};

}  // namespace kalfem
