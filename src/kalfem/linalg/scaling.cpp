// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/scaling.hpp"

#include <cassert>
#include <cmath>

namespace kalfem {

namespace {

double off_diagonal_norm(const Eigen::MatrixXd& A, Eigen::Index i, bool column) {
  const double all = column ? A.col(i).lpNorm<1>() : A.row(i).lpNorm<1>();
  return all - std::abs(A(i, i));
}

/// The power of two nearest to sqrt(row / column), 1 where one of them vanishes.
double equalising_factor(double row, double column) {
  if (!(row > 0.0) || !(column > 0.0)) return 1.0;
  return std::exp2(std::round(0.5 * (std::log2(row) - std::log2(column))));
}

}  // namespace

Eigen::VectorXd balancing_scale(Eigen::MatrixXd A) {
  assert(A.rows() == A.cols() && A.allFinite());
  constexpr int sweeps = 20;  // a handful settles it; the bound only guards against cycling
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(A.rows());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    bool changed = false;
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      const double factor = equalising_factor(off_diagonal_norm(A, i, false), off_diagonal_norm(A, i, true));
      if (factor == 1.0) continue;
      A.col(i) *= factor;
      A.row(i) /= factor;
      scale(i) *= factor;
      changed = true;
    }
    if (!changed) break;
  }
  return scale;
}

Eigen::MatrixXd unit_columns(const Eigen::MatrixXd& columns) {
  // Lengths are evaluated before the product: as an expression they would be summed up anew for every entry of it.
  const Eigen::RowVectorXd lengths = columns.colwise().norm();
  const Eigen::RowVectorXd factors = (lengths.array() > 0.0).select(lengths.cwiseInverse(), 0.0);
  return columns * factors.asDiagonal();
}

}  // namespace kalfem
