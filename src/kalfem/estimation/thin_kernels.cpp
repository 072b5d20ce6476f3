#include "kalfem/estimation/thin_kernels.hpp"

#include <algorithm>

#include "kalfem/estimation/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Y += sign X M or sign X M^T, four columns of Y at a time.
template <int sign, bool transposed>
void accumulate(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  const Index rows = x.rows(), depth = transposed ? m.cols() : m.rows(), columns = y.cols();
  const Index k_stride = transposed ? m.rows() : 1, j_stride = transposed ? 1 : m.rows();
  for (Index row = 0; row < rows; row += lane_count) {
    const double* from = x.data() + row;
    double* to = y.data() + row;
    Index j = 0;
    for (; j + 4 <= columns; j += 4) {
      const double* factor = m.data() + j * j_stride;
      Lanes sum[4];
#pragma GCC unroll 4
      for (int c = 0; c < 4; ++c) sum[c] = load(to + (j + c) * rows);
      for (Index k = 0; k < depth; ++k) {
        const Lanes value = load(from + k * rows);
#pragma GCC unroll 4
        for (int c = 0; c < 4; ++c) sum[c] += value * (sign * factor[k * k_stride + c * j_stride]);
      }
#pragma GCC unroll 4
      for (int c = 0; c < 4; ++c) store(to + (j + c) * rows, sum[c]);
    }
    for (; j < columns; ++j) {
      const double* factor = m.data() + j * j_stride;
      Lanes sum = load(to + j * rows);
      for (Index k = 0; k < depth; ++k) sum += load(from + k * rows) * (sign * factor[k * k_stride]);
      store(to + j * rows, sum);
    }
  }
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
  accumulate<1, false>(x, m, y);
}

void add_thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) { accumulate<1, false>(x, m, y); }

void subtract_thin_product_transposed(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  accumulate<-1, true>(x, m, y);
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
