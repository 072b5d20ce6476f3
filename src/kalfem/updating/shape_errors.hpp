// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/updating/measured_mode.hpp"

namespace kalfem {

/// What is known of the errors of a measured shape, whose scale is free.
///
/// Entries that are not numbers were not measured: they are left out. Of the others, errors with the covariance
/// Sigma = L L^T are made independent and of unit size by L^-1, so that a least-squares fit c of L^-1 (A c - phi) is
/// the most likely one. As the fit chooses the scale, an error along phi itself tells nothing: Sigma + kappa phi phi^T
/// leaves the rest of the fit unchanged for any kappa (to first order) and makes a covariance regular that is singular
/// because the shape was normalised at one entry.
class ShapeErrors {
public:
  /// Independent errors. `deviations`: one an entry, > 0 where it was measured.
  ShapeErrors(const Eigen::VectorXd& shape, const Eigen::VectorXd& deviations);
  /// Errors with a covariance, n x n. It must be symmetric, positive semidefinite and finite where entries were
  /// measured.
  static ShapeErrors correlated(const Eigen::VectorXd& shape, const Eigen::MatrixXd& covariance);

  /// The same where the scale is the measured one: an error along phi counts. To the variances 1e-4 of the largest is
  /// added, as the entry at which a shape was normalised has none.
  static ShapeErrors at_given_scale(const Eigen::VectorXd& shape, const Eigen::MatrixXd& covariance);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(measured_.size()); }
  /// The measured entries of columns over all points, size() x columns.
  [[nodiscard]] Eigen::MatrixXd of_measured(const Eigen::MatrixXd& columns) const {
    return columns(measured_, Eigen::all);
  }
  /// L^-1 of them.
  [[nodiscard]] Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns) const;

private:
  std::vector<Eigen::Index> measured_;
  Eigen::VectorXd deviations_;          ///< of the measured entries, where they are independent
  Eigen::LLT<Eigen::MatrixXd> factor_;  ///< of their covariance, otherwise
};

enum class ShapeScale { free, given };

/// By what is known of a measured shape: its covariance, or deviations by entry, or one deviation for all.
ShapeErrors shape_errors_of(const MeasuredMode& mode, ShapeScale scale = ShapeScale::free);

}  // namespace kalfem
