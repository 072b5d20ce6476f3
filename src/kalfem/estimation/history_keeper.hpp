// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/unknowns_history.hpp"

namespace kalfem {

/// Places in the augmented state of the constant unknowns, those without random walk.
std::vector<Eigen::Index> constant_states(const AugmentedModel& augmented_model);

/// Keeps the history of the constant unknowns along a run over a record. Long histories of
/// many unknowns are kept at some samples only. One run.
class HistoryKeeper {
public:
  /// `prior`: of the augmented state. A record of so many samples and channels.
  HistoryKeeper(const AugmentedModel& augmented_model, const Gaussian& prior, Eigen::Index samples,
                Eigen::Index channels);

  /// What the filter knows after the update of sample k, of which `innovation` tells. Samples come in their order.
  void keep(Eigen::Index k, const Filter& filter, const Innovation& innovation);

  /// The history up to the last sample that was kept. The keeper is of no use afterwards.
  UnknownsHistory take();

private:
  void keep_point(const Filter& filter);
  void keep_slope(Eigen::Index k, const Filter& filter, const Innovation& innovation);

  UnknownsHistory history_;
  Eigen::Index samples_;
  std::vector<Eigen::Index> states_;      ///< places of the constants in the augmented state
  Eigen::Index points_ = 0, slopes_ = 0;  ///< that are kept
  bool keeps_slopes_ = false;
  Eigen::MatrixXd covariance_, gain_;         ///< of the constants: P after the update and K
  Eigen::MatrixXd before_, factor_;           ///< P before the update and its Cholesky factor L
  Eigen::MatrixXd cross_, whitened_, slope_;  ///< P_y,theta, P_y,theta L^-T and D^T
  Eigen::MatrixXd innovation_covariance_;     ///< S
  Eigen::VectorXd moved_, known_;
};

}  // namespace kalfem
