// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/gaussian.hpp"

namespace kalfem {

/// What a filter that doubts itself begins anew from: its last consistent estimate, and how far the structure has moved
/// while it was consistent. In physical coordinates.
class LastConsistent {
public:
  LastConsistent() = default;
  /// Of a filter that has learned nothing yet.
  LastConsistent(const AugmentedModel& model, const Gaussian& prior);

  /// The filter is consistent at `now`, in the model's coordinates.
  void remember(const AugmentedModel& model, const Gaussian& now);

  /// An estimate in the model's coordinates. Unknowns have the means of the last consistent one, and deviations `wider`
  /// times as large, at most those of the prior. Everything else has its prior mean and may be anywhere where it has
  /// been: where the structure is in its motion is not known.
  [[nodiscard]] Gaussian again(const AugmentedModel& model, double wider) const;

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.prior_.mean);
    archive(self.prior_.covariance);
    archive(self.estimate_.mean);
    archive(self.estimate_.covariance);
    archive(self.mean_square_);
    archive(self.count_);
  }

private:
  Gaussian prior_, estimate_;
  Eigen::VectorXd mean_square_;  ///< of every state's mean less its prior mean
  double count_ = 0.0;           ///< of the estimates in it, a few latest ones at most
};

/// The covariance with deviations times `factor`, correlations as they are. Those of unknowns grow at most to those of
/// `prior`, and none shrinks.
Eigen::MatrixXd widened(const Eigen::MatrixXd& covariance, double factor, Eigen::Index first_unknown,
                        const Eigen::MatrixXd& prior);

}  // namespace kalfem
