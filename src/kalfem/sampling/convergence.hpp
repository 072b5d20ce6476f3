// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Whether chains have met, and how many independent draws they are worth.
struct Convergence {
  double r_hat = 0.0;     ///< larger of rank-normalised split R-hat and that of the folded draws; infinite if stuck
  double bulk_ess = 0.0;  ///< effective sample size for the centre
  double tail_ess = 0.0;  ///< smaller one of those of the 5 and 95 % quantiles

  /// r_hat < 1.01 and both sizes at least 100 a chain, as Vehtari et al. advise.
  [[nodiscard]] bool reached(Eigen::Index chains) const {
    return r_hat < 1.01 && bulk_ess >= 100.0 * static_cast<double>(chains) &&
           tail_ess >= 100.0 * static_cast<double>(chains);
  }
};

/// Of one quantity, draws x chains with at least 8 draws (Vehtari, Gelman, Simpson, Carpenter and Buerkner 2021,
/// Bayesian Analysis 16, 667-718).
Convergence convergence_of(const Eigen::Ref<const Eigen::MatrixXd>& draws);

/// R-hat of chains split in halves, without ranks.
double split_r_hat(const Eigen::Ref<const Eigen::MatrixXd>& draws);
/// Effective sample size of the mean over chains split in halves, by Geyer's initial monotone sequence.
double effective_sample_size(const Eigen::Ref<const Eigen::MatrixXd>& draws);
/// Normal scores of the ranks over all chains, ties shared: Phi^-1((r - 3/8) / (S + 1/4)).
Eigen::MatrixXd rank_normalised(const Eigen::Ref<const Eigen::MatrixXd>& draws);

}  // namespace kalfem
