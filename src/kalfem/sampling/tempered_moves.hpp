// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/sampling/tempered_sampler.hpp"

namespace kalfem {

/// Samples of one moment, by columns.
struct Population {
  Eigen::MatrixXd z;
  Eigen::VectorXd log_likelihood;
};

/// Metropolis moves that leave N(z; 0, I) L(z)^beta unchanged, tuned by the weighted samples of the stage before (after
/// ter Braak 2006, Stat. Comput. 16, 239-249). Every second one is a walk:
///     walk         z + s 2.38 / sqrt(p) C e, C C^T the covariance, e ~ N(0, I), s adapted to the acceptance
///     difference   z + g (z_a - z_b) + small walk, z_a and z_b from the stage before, g uniform
///     jump         the same with g = 1: from one mode to another
class TemperedMover {
public:
  /// `archive`: samples of the stage before, kept by reference; `probability`: their weights, which sum to one.
  TemperedMover(const Posterior& posterior, const TemperedOptions& options, double exponent, const Population& archive,
                const Eigen::VectorXd& probability, double scale);

  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] long long evaluations() const { return evaluations_; }
  [[nodiscard]] double acceptance() const;

  /// Move `number` of each sample, side by side; sample i draws from random[i]. Throws Interrupted.
  void round(Population& now, std::vector<RandomStream>& random, int number);

private:
  enum class Kind { walk, difference, jump };

  void adapt(double rate);
  [[nodiscard]] Eigen::Index draw(RandomStream& random) const;
  [[nodiscard]] Eigen::VectorXd proposal(const Eigen::VectorXd& z, RandomStream& random, Kind kind) const;
  bool move(Population& now, Eigen::Index i, RandomStream& random, Kind kind) const;

  const Posterior& posterior_;
  const TemperedOptions& options_;
  double exponent_;
  const Eigen::MatrixXd& archive_;
  Eigen::MatrixXd factor_;
  std::vector<double> cumulative_;
  double scale_;
  long long accepted_ = 0;
  long long evaluations_ = 0;
};

}  // namespace kalfem
