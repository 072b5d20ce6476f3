#include "kalfem/estimation/partially_linear/argument_factor.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double pivot_floor = 1e-12;  ///< of an argument's variance; its root is far above rounding
/// Of the largest square that a covariance can have beside its two variances: beyond it they are rounding.
constexpr double impossible = 1.01;

}  // namespace

bool argument_factor(const MatrixXd& covariance, MatrixXd& factor) {
  const Index q = covariance.rows();
  factor.setZero(q, q);
  for (Index j = 0; j < q; ++j) {
    const double variance = covariance(j, j);
    if (!(variance >= 0.0) || !std::isfinite(variance)) return false;
    if (variance == 0.0) continue;
    double pivot = variance;
    for (Index k = 0; k < j; ++k) pivot -= factor(j, k) * factor(j, k);
    if (!(pivot > pivot_floor * variance)) {  // what is left of its covariances with others is rounding
      factor(j, j) = std::sqrt(pivot_floor * variance);
      continue;
    }
    factor(j, j) = std::sqrt(pivot);
    const double inverse = 1.0 / factor(j, j);
    bool possible = true;
    for (Index i = j + 1; i < q; ++i) {
      double value = covariance(i, j);
      for (Index k = 0; k < j; ++k) value -= factor(i, k) * factor(j, k);
      factor(i, j) = value * inverse;
      possible = possible && !(factor(i, j) * factor(i, j) > impossible * covariance(i, i));
    }
    if (!possible) factor.col(j).tail(q - j - 1).setZero();
  }
  return factor.allFinite();
}

bool independent_argument_factor(const MatrixXd& covariance, Dependent dependent, MatrixXd& factor,
                                 std::vector<Index>& independent) {
  const Index q = covariance.rows();
  factor.setZero(q, q);
  independent.clear();
  for (Index j = 0; j < q; ++j) {
    const double variance = covariance(j, j);
    if (!(variance >= 0.0) || !std::isfinite(variance)) return false;
    const auto found = static_cast<Index>(independent.size());
    double pivot = variance;
    for (Index k = 0; k < found; ++k) pivot -= factor(j, k) * factor(j, k);
    if (!(pivot > pivot_floor * variance)) {  // what is left of its covariances with others is rounding
      if (dependent == Dependent::left_out || variance == 0.0) continue;
      factor(j, found) = std::sqrt(pivot_floor * variance);
      independent.push_back(j);
      continue;
    }
    auto column = factor.col(found).tail(q - j);
    column = covariance.col(j).tail(q - j);
    for (Index k = 0; k < found; ++k) column -= factor(j, k) * factor.col(k).tail(q - j);
    column /= std::sqrt(pivot);
    column[0] = std::sqrt(pivot);
    const auto variances = covariance.diagonal().tail(q - j).array();
    if ((column.array().square().tail(q - j - 1) > impossible * variances.tail(q - j - 1)).any())
      column.tail(q - j - 1).setZero();
    independent.push_back(j);
  }
  return factor.allFinite();
}

void solve_independent_transposed(const MatrixXd& factor, const std::vector<Index>& independent, const MatrixXd& b,
                                  MatrixXd& f) {
  const auto count = static_cast<Index>(independent.size());
  f.setZero(factor.rows(), b.cols());
  for (Index i = count - 1; i >= 0; --i) {
    const Index row = independent[static_cast<std::size_t>(i)];
    f.row(row) = b.row(i);
    for (Index k = i + 1; k < count; ++k) {
      const Index later = independent[static_cast<std::size_t>(k)];
      f.row(row) -= factor(later, i) * f.row(later);
    }
    f.row(row) /= factor(row, i);
  }
}

void solve_arguments(const MatrixXd& factor, MatrixXd& b) {
  const Index q = factor.rows();
  for (Index column = 0; column < b.cols(); ++column)
    for (Index i = 0; i < q; ++i) {
      if (factor(i, i) == 0.0) {
        b(i, column) = 0.0;
        continue;
      }
      double value = b(i, column);
      for (Index k = 0; k < i; ++k) value -= factor(i, k) * b(k, column);
      b(i, column) = value / factor(i, i);
    }
}

}  // namespace kalfem
