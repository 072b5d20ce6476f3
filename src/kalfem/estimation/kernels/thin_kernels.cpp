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

/// Sums of the lanes of eight vectors.
Lanes sums_of(const Lanes (&in)[8]) {
  Lanes columns[8];
  transpose(in, columns);
  return ((columns[0] + columns[1]) + (columns[2] + columns[3])) +
         ((columns[4] + columns[5]) + (columns[6] + columns[7]));
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

void thin_inner(const MatrixXd& x, const MatrixXd& y, MatrixXd& m) {
  const Index rows = x.rows();
  for (Index i = 0; i < x.cols(); i += 8) {
    const Index count = std::min<Index>(8, x.cols() - i);
    const double* left[8];  // the last column stands for those that are missing
    for (Index c = 0; c < 8; ++c) left[c] = x.data() + (i + std::min(c, count - 1)) * rows;
    for (Index j = 0; j < y.cols(); ++j) {
      const double* right = y.data() + j * rows;
      Lanes sums[8] = {};
      for (Index row = 0; row < rows; row += lane_count) {
        const Lanes value = load(right + row);
#pragma GCC unroll 8
        for (int c = 0; c < 8; ++c) sums[c] += value * load(left[c] + row);
      }
      const Lanes result = sums_of(sums);
      for (Index c = 0; c < count; ++c) m(i + c, j) = result[c];
    }
  }
}

}  // namespace kalfem
