// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Measured shapes beside the model's, pair by pair, each with its best scale:
///     J = sum over pairs of min_c |c a - f|^2 / |f|^2 = sum (1 - MAC),
/// and J with some rows of the model exchanged, at the cost of these rows alone.
class ShapeFit {
public:
  /// Sensors x pairs. Entries of `measured` that are not numbers are left out.
  ShapeFit(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& model);

  [[nodiscard]] double misfit() const { return misfit_of(products_); }
  /// The MAC of each pair.
  [[nodiscard]] Eigen::VectorXd mac() const;
  /// With other motions of the model at these sensors, rows x pairs.
  [[nodiscard]] double misfit_with(const std::vector<Eigen::Index>& rows, const Eigen::MatrixXd& motions) const;
  /// The scale of each pair, fitted without these sensors.
  [[nodiscard]] Eigen::VectorXd scales_without(const std::vector<Eigen::Index>& rows) const;
  /// The measured entry, 0 where there is none.
  [[nodiscard]] double measured(Eigen::Index row, Eigen::Index pair) const { return measured_(row, pair); }
  [[nodiscard]] Eigen::Index entries() const { return entries_; }  ///< that were measured
  [[nodiscard]] Eigen::Index pairs() const { return measured_.cols(); }
  [[nodiscard]] Eigen::Index sensors() const { return measured_.rows(); }
  [[nodiscard]] const Eigen::MatrixXd& model() const { return model_; }

private:
  /// a^T a and a^T f of each pair; f^T f is 1.
  struct Products {
    Eigen::ArrayXd model, mixed;
  };
  static double misfit_of(const Products& products);
  void exchange(Products& products, Eigen::Index row, const Eigen::RowVectorXd& motion, double sign) const;

  Eigen::MatrixXd measured_;  ///< each column of length 1, gaps 0
  Eigen::MatrixXd given_;     ///< 1 where an entry was measured
  Eigen::MatrixXd model_;
  Products products_;
  Eigen::Index entries_ = 0;
};

}  // namespace kalfem
