// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/small_kernels.hpp"

#include <algorithm>

#include "kalfem/estimation/kernels/kernel_set.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

KernelMatrix plain(const MatrixXd& matrix) { return {matrix.data(), matrix.rows()}; }
KernelMatrix transposed(const MatrixXd& matrix) { return {matrix.data(), matrix.rows(), true}; }

void product(Keep keep, Shape shape, const MatrixXd& a, KernelMatrix b, MatrixXd& c) {
  kernels().product(keep, shape, c.rows(), c.cols(), a.cols(), plain(a), b, c.data(), c.rows());
}

}  // namespace

void copy(const MatrixXd& a, MatrixXd& b) {
  b.resize(a.rows(), a.cols());
  std::copy_n(a.data(), a.size(), b.data());
}

void multiply(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  out.resize(a.rows(), b.cols());
  product(Keep::nothing, Shape::full, a, plain(b), out);
}

void multiply_lower(const MatrixXd& a, const MatrixXd& lower, MatrixXd& out) {
  out.resize(a.rows(), lower.rows());
  product(Keep::nothing, Shape::lower_factor, a, plain(lower), out);
}

void multiply_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  out.resize(a.rows(), b.rows());
  product(Keep::nothing, Shape::full, a, transposed(b), out);
}

void add_product_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  product(Keep::sum, Shape::full, a, transposed(b), out);
}

void add_symmetric_product(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  product(Keep::sum, Shape::lower_result, a, transposed(b), out);
}

void subtract_square(const MatrixXd& a, MatrixXd& out) {
  product(Keep::difference, Shape::lower_result, a, transposed(a), out);
}

bool cholesky(const MatrixXd& p, double pivot_floor, MatrixXd& lower) {
  const Index n = p.rows();
  copy(p, lower);
  const bool usable = kernels().cholesky(n, pivot_floor, p.data(), n + 1, lower.data());
  for (Index j = 1; j < n; ++j)
    for (Index i = 0; i < j; ++i) lower(i, j) = 0.0;
  return usable;
}

void solve_on_the_right(const MatrixXd& lower, MatrixXd& b) {
  for (Index j = 0; j < b.cols(); ++j) {
    for (Index k = 0; k < j; ++k) b.col(j) -= lower(j, k) * b.col(k);
    b.col(j) *= 1.0 / lower(j, j);
  }
}

}  // namespace kalfem
