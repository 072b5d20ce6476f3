// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/base/resumable.hpp"
#include "kalfem/estimation/gaussian.hpp"
#include "kalfem/estimation/partially_linear/covariance_tiles.hpp"
#include "kalfem/estimation/partially_linear/projected_rows.hpp"

namespace kalfem {

/// Mean x and covariance P of a state, and their view through fixed rows H: the products [P H^T, x] and the small
/// matrix H [P H^T, x]. Every change of the estimate goes through this object, which brings the products along, so they
/// belong to the estimate at any time. Only here is it known that the last update's J J^T has not been taken from the
/// stored P yet: that waits for the next pass over P, which reads and writes all of it. K rows; slots are places of
/// states in tiles (TileLayout).
class ProjectedCovariance final : public Resumable {
public:
  ProjectedCovariance(ProjectedRows rows, TileLayout layout, int threads);

  void reset(const Gaussian& estimate);
  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;
  /// x <- mean (slots x 1) and P by one pass, see CovarianceStep; its downdate and its rows are set here. `propagated`:
  /// the products of the propagated rows with the new P, slots x such rows.
  void propagate(CovarianceStep step, const Eigen::MatrixXd& propagated, const Eigen::MatrixXd& mean);
  /// Takes a J J^T that waits from the stored P, so that the next update may wait in turn.
  void settle();
  /// x <- x + J v, P <- P - J J^T with J = (P H^T) C: C is K x l, v has l values. Nothing may wait: settle() first.
  void condition(const Eigen::MatrixXd& combination, const Eigen::VectorXd& whitened);
  /// P B of any B, slots x columns: a pass over P.
  void multiply(const Eigen::MatrixXd& columns, Eigen::MatrixXd& product);

  [[nodiscard]] const ProjectedRows& rows() const { return rows_; }
  [[nodiscard]] const Eigen::MatrixXd& products() const { return products_; }  ///< [P H^T, x], slots x (K + 1)
  /// H [P H^T, x]: K rows, then zeros to a multiple of eight, x (K + 1).
  [[nodiscard]] const Eigen::MatrixXd& gram() const { return gram_; }
  [[nodiscard]] auto mean() const { return products_.col(rows_.size()); }      ///< x, slots
  [[nodiscard]] const Eigen::MatrixXd& downdate() const { return downdate_; }  ///< J of the last update, slots x l
  [[nodiscard]] Eigen::VectorXd variances() const;                             ///< the diagonal of P, slots
  [[nodiscard]] Eigen::MatrixXd covariance() const;                            ///< P in the order of the states
  [[nodiscard]] Eigen::MatrixXd covariance_of(const std::vector<Eigen::Index>& states) const;  ///< P of these alone

private:
  void pass(CovarianceStep step, Eigen::MatrixXd& product);
  void complete_products();

  ProjectedRows rows_;
  TileLayout layout_;
  CovarianceTiles stored_;  ///< P, or P + J J^T while a downdate waits
  bool downdate_waits_ = false;
  Eigen::MatrixXd downdate_;                           ///< J, slots x l
  Eigen::MatrixXd products_, dense_, gram_;            ///< `dense_`: the rows of H that pick no state
  Eigen::MatrixXd rows_of_downdate_, rows_and_score_;  ///< H J, [H J; -v^T]
};

}  // namespace kalfem
