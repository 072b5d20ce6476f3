// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/argument_factor.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double pivot_floor = 1e-12;  ///< of an argument's variance; its root is far above rounding
/// Of the largest square that a covariance can have beside its two variances: beyond it they are rounding.
constexpr double impossible = 1.01;

/// Column `found` of the factor, of argument j with the pivot root^2, from those before; the factor's rows are padded.
void set_column(const MatrixXd& covariance, Index j, Index found, double root, MatrixXd& factor) {
  const Index q = covariance.rows(), first = j - j % lane_count;
  double* column = &factor(0, found);
  for (Index i = j; i < q; ++i) column[i] = covariance(i, j);
  for (Index block = first; block < factor.rows(); block += lane_count) {
    Lanes sum = load(column + block);
    for (Index k = 0; k < found; ++k) {
      const Lanes product = load(&factor(block, k)) * factor(j, k);
      sum = sum - product;
    }
    store(column + block, sum / root);
  }
  constexpr Lanes places = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  const Lanes above = load(column + first);
  store(column + first, places < static_cast<double>(j - first) ? Lanes{} : above);
  column[j] = root;
  bool possible = true;
  for (Index i = j + 1; i < q; ++i) possible &= !(column[i] * column[i] > impossible * covariance(i, i));
  if (!possible) std::fill(column + j + 1, column + q, 0.0);
}

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
  factor.setZero(whole_lanes(q), q);
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
    set_column(covariance, j, found, std::sqrt(pivot), factor);
    independent.push_back(j);
  }
  return (0.0 * factor).sum() == 0.0;  // finite
}

void solve_independent_transposed(const MatrixXd& factor, const std::vector<Index>& independent, const MatrixXd& b,
                                  MatrixXd& f_transposed) {
  const auto count = static_cast<Index>(independent.size());
  const auto place = [&](Index i) { return independent[static_cast<std::size_t>(i)]; };
  f_transposed.setZero(whole_lanes(b.cols()), factor.cols());
  for (Index i = count - 1; i >= 0; --i) {
    f_transposed.col(place(i)).head(b.cols()) = b.row(i).transpose();
    for (Index block = 0; block < f_transposed.rows(); block += lane_count) {
      Lanes sum = load(&f_transposed(block, place(i)));
      for (Index k = i + 1; k < count; ++k) {
        const Lanes product = load(&f_transposed(block, place(k))) * factor(place(k), i);
        sum = sum - product;
      }
      store(&f_transposed(block, place(i)), sum / factor(place(i), i));
    }
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
