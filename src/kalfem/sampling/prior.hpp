#pragma once

#include <Eigen/Dense>
#include <limits>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {

/// N(mean, deviation^2), truncated to [lower, upper].
struct NormalPrior {
  double mean = 0.0;
  double deviation = 1.0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// ln theta ~ N(ln median, log_deviation^2), truncated to [lower, upper].
struct LogNormalPrior {
  double median = 1.0;
  double log_deviation = 1.0;
  double lower = 0.0;
  double upper = std::numeric_limits<double>::infinity();
};

/// Constant on [lower, upper].
struct UniformPrior {
  double lower = 0.0;
  double upper = 1.0;
};

using MarginalPrior = std::variant<NormalPrior, LogNormalPrior, UniformPrior>;

/// Where a parameter has prior density.
struct Support {
  double lower = 0.0;
  double upper = 0.0;
};

/// Of one marginal, truncation included. x = from_normal(w) is the value whose probability is that of the standard
/// normal w, found from the nearer tail: exact far out on both sides.
Support support(const MarginalPrior& marginal);
double log_density(const MarginalPrior& marginal, double x);  ///< normalised; -infinity outside the support
double from_normal(const MarginalPrior& marginal, double w);
double to_normal(const MarginalPrior& marginal, double x);  ///< within +-37, where double precision ends
double mean(const MarginalPrior& marginal);
double deviation(const MarginalPrior& marginal);

/// What is wrong with a prior: no parameters, deviations that are not positive, bounds in the wrong order or without
/// probability between them (under 1e-250), improper (unbounded uniform) marginals, and a correlation matrix that is no
/// p x p symmetric positive definite one with a unit diagonal. `correlation`: may be empty.
IssueList validate(const Named<MarginalPrior>& marginals, const Eigen::MatrixXd& correlation = {});

/// Joint prior of named parameters theta (p): marginals, coupled by a Gaussian copula,
///     theta_i = F_i^-1(Phi(w_i)),   w = L z,   z ~ N(0, I),   L L^T = R,
/// with the correlation R of the normal scores w, which is that of the parameters if they are normal. The samplers
/// work on z, where every proper prior is standard normal and unbounded.
class JointPrior {
public:
  JointPrior() = default;
  /// Throws InvalidInput with all that validate() finds. `correlation`: R, p x p; independent if empty.
  explicit JointPrior(Named<MarginalPrior> marginals, Eigen::MatrixXd correlation = {});

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(marginals_.size()); }
  [[nodiscard]] const Named<MarginalPrior>& marginals() const { return marginals_; }
  [[nodiscard]] const Eigen::MatrixXd& correlation() const { return correlation_; }  ///< empty if independent

  /// ln p(theta), normalised; -infinity outside the support, and where theta is not a number.
  [[nodiscard]] double log_density(const Eigen::VectorXd& theta) const;
  [[nodiscard]] Eigen::VectorXd sample(RandomStream& random) const;
  [[nodiscard]] Eigen::VectorXd from_standard_normal(const Eigen::VectorXd& z) const;  ///< theta
  [[nodiscard]] Eigen::VectorXd to_standard_normal(const Eigen::VectorXd& theta) const;
  [[nodiscard]] Eigen::VectorXd mean() const;       ///< of the marginals
  [[nodiscard]] Eigen::VectorXd deviation() const;  ///< of the marginals

private:
  Named<MarginalPrior> marginals_;
  Eigen::MatrixXd correlation_;
  Eigen::MatrixXd factor_;  ///< L, lower triangular; empty if independent
};

}  // namespace kalfem
