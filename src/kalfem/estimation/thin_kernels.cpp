#include "kalfem/estimation/thin_kernels.hpp"

#include "kalfem/estimation/vector_lanes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Y += sign X M or X M^T, four columns of Y at a time.
template <int sign, bool transposed>
void accumulate(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  const Index rows = x.rows(), depth = x.cols(), columns = y.cols();
  const auto entry = [&](Index k, Index j) { return sign * (transposed ? m(j, k) : m(k, j)); };
  for (Index row = 0; row < rows; row += lane_count) {
    Index j = 0;
    for (; j + 4 <= columns; j += 4) {
      Lanes sum[4];
#pragma GCC unroll 4
      for (int c = 0; c < 4; ++c) sum[c] = load(&y(row, j + c));
      for (Index k = 0; k < depth; ++k) {
        const Lanes value = load(&x(row, k));
#pragma GCC unroll 4
        for (int c = 0; c < 4; ++c) sum[c] += value * entry(k, j + c);
      }
#pragma GCC unroll 4
      for (int c = 0; c < 4; ++c) store(&y(row, j + c), sum[c]);
    }
    for (; j < columns; ++j) {
      Lanes sum = load(&y(row, j));
      for (Index k = 0; k < depth; ++k) sum += load(&x(row, k)) * entry(k, j);
      store(&y(row, j), sum);
    }
  }
}

double sum_of(const Lanes& v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

}  // namespace

void thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  y.setZero(x.rows(), m.cols());
  accumulate<1, false>(x, m, y);
}

void add_thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) { accumulate<1, false>(x, m, y); }

void add_thin_product_transposed(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) { accumulate<1, true>(x, m, y); }

void subtract_thin_product_transposed(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  accumulate<-1, true>(x, m, y);
}

void thin_inner(const MatrixXd& x, const MatrixXd& y, MatrixXd& m) {
  m.resize(x.cols(), y.cols());
  for (Index i = 0; i < x.cols(); ++i) {
    Index j = 0;
    for (; j + 4 <= y.cols(); j += 4) {
      Lanes sum[4] = {};
      for (Index row = 0; row < x.rows(); row += lane_count) {
        const Lanes value = load(&x(row, i));
#pragma GCC unroll 4
        for (int c = 0; c < 4; ++c) sum[c] += value * load(&y(row, j + c));
      }
#pragma GCC unroll 4
      for (int c = 0; c < 4; ++c) m(i, j + c) = sum_of(sum[c]);
    }
    for (; j < y.cols(); ++j) {
      Lanes sum = {};
      for (Index row = 0; row < x.rows(); row += lane_count) sum += load(&x(row, i)) * load(&y(row, j));
      m(i, j) = sum_of(sum);
    }
  }
}

}  // namespace kalfem
