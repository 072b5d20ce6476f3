// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/sampling/marginal_prior.hpp"

namespace kalfem {

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
