// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/thin_kernels.hpp"

#include <algorithm>

#include "kalfem/estimation/kernels/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// The right-hand factor, entry (k, j), as it stands or transposed.
struct Factor {
  const double* data;
  Index k_stride, j_stride;
};

/// `height` times eight rows and `width` columns of Y += sign X M: as many sums at once as hide the time of one.
template <int sign, int height, int width>
[[gnu::always_inline]] inline void add_block(Index rows, Index depth, const double* x, const Factor& m, double* y) {
  Lanes sum[height][width];
#pragma GCC unroll 8
  for (int r = 0; r < height; ++r)
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c) sum[r][c] = load(y + c * rows + r * lane_count);
  for (Index k = 0; k < depth; ++k) {
    const double* factor = m.data + k * m.k_stride;
#pragma GCC unroll 8
    for (int r = 0; r < height; ++r) {
      const Lanes value = load(x + k * rows + r * lane_count);
#pragma GCC unroll 8
      for (int c = 0; c < width; ++c) sum[r][c] += value * (sign * factor[c * m.j_stride]);
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < height; ++r)
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c) store(y + c * rows + r * lane_count, sum[r][c]);
}

/// All rows of `width` columns.
template <int sign, int width, int height = 8 / width>
void add_columns(Index row, Index rows, Index depth, const double* x, const Factor& m, double* y) {
  for (; rows - row >= height * lane_count; row += height * lane_count)
    add_block<sign, height, width>(rows, depth, x + row, m, y + row);
  if constexpr (height > 1)
    if (row < rows) add_columns<sign, width, height / 2>(row, rows, depth, x, m, y);
}

/// Y += sign X M, panels of columns from `j` on.
template <int sign, int width = 4>
void add(Index j, const MatrixXd& x, Index depth, const Factor& m, MatrixXd& y) {
  const Index rows = x.rows();
  for (; y.cols() - j >= width; j += width)
    add_columns<sign, width>(0, rows, depth, x.data(), {m.data + j * m.j_stride, m.k_stride, m.j_stride},
                             y.data() + j * rows);
  if constexpr (width > 1)
    if (j < y.cols()) add<sign, width / 2>(j, x, depth, m, y);
}

/// Eight rows and `width` columns of M = X^T Y. Eight sums at once for each column, over every eighth row of Y: a
/// single one would wait for its own additions.
template <int width>
[[gnu::always_inline]] inline void inner_block(Index height, Index rows, const double* x, const double* y, double* m,
                                               Index m_rows) {
  Lanes sums[width][8] = {};
  for (Index row = 0; row < rows; row += lane_count)
#pragma GCC unroll 8
    for (int r = 0; r < lane_count; ++r) {
      const Lanes left = load(x + (row + r) * height);
#pragma GCC unroll 2
      for (int c = 0; c < width; ++c) sums[c][r] += left * y[c * rows + row + r];
    }
#pragma GCC unroll 2
  for (int c = 0; c < width; ++c) {
    const auto& sum = sums[c];
    store(m + c * m_rows, ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7])));
  }
}

}  // namespace

void thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  y.setZero(x.rows(), m.cols());
  add_thin_product(x, m, y);
}

void add_thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  add<1>(0, x, m.rows(), {m.data(), 1, m.rows()}, y);
}

void subtract_thin_product_transposed(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  add<-1>(0, x, m.cols(), {m.data(), m.rows(), 1}, y);
}

void thin_inner(const MatrixXd& x_transposed, const MatrixXd& y, MatrixXd& m) {
  const Index rows = y.rows(), height = x_transposed.rows();
  for (Index i = 0; i < height; i += lane_count) {
    const double* x = x_transposed.data() + i;
    Index j = 0;
    for (; j + 2 <= y.cols(); j += 2) inner_block<2>(height, rows, x, &y(0, j), &m(i, j), m.rows());
    if (j < y.cols()) inner_block<1>(height, rows, x, &y(0, j), &m(i, j), m.rows());
  }
}

}  // namespace kalfem
