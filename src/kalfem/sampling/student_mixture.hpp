// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/base/random.hpp"
#include "kalfem/sampling/normal_approximation.hpp"

namespace kalfem {

/// Multivariate Student t distribution of z (p) about the mean m, with nu degrees of freedom and the scale matrix S,
///     p(z) = c (1 + (z - m)^T S^-1 (z - m) / nu)^(-(nu + p) / 2),
///     c = Gamma((nu + p) / 2) / (Gamma(nu / 2) (nu pi)^(p/2) det(S)^(1/2)),
/// or the normal distribution N(m, S) where nu = 0.
class StudentDistribution {
public:
  /// `scale`: mean m and S, which gets a small diagonal where it is singular.
  StudentDistribution(const NormalApproximation& scale, int degrees);

  [[nodiscard]] double log_density(const Eigen::VectorXd& z) const;
  [[nodiscard]] Eigen::VectorXd draw(RandomStream& random) const;

private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd factor_;  ///< lower triangular, S = L L^T
  int degrees_;
  double log_constant_;
};

/// sum_d a_d p_d(z), shares a_d that sum to one.
struct StudentMixture {
  std::vector<StudentDistribution> components;
  std::vector<double> shares;

  [[nodiscard]] double log_density(const Eigen::VectorXd& z) const;
  /// From the component in which `place`, between 0 and 1, lies along the shares: places at even distances from one
  /// random offset draw from each component as often as its share says.
  [[nodiscard]] Eigen::VectorXd draw(double place, RandomStream& random) const;
};

}  // namespace kalfem
