// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/thin_kernels.hpp"

#include "kalfem/estimation/kernels/kernel_set.hpp"

namespace kalfem {

using Eigen::MatrixXd;

void thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  y.setZero(x.rows(), m.cols());
  add_thin_product(x, m, y);
}

void add_thin_product(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  kernels().thin_add(1.0, x.rows(), y.cols(), m.rows(), x.data(), {m.data(), m.rows()}, y.data());
}

void subtract_thin_product_transposed(const MatrixXd& x, const MatrixXd& m, MatrixXd& y) {
  kernels().thin_add(-1.0, x.rows(), y.cols(), m.cols(), x.data(), {m.data(), m.rows(), true}, y.data());
}

void thin_inner(const MatrixXd& x_transposed, const MatrixXd& y, MatrixXd& m) {
  kernels().thin_inner(x_transposed.rows(), y.rows(), y.cols(), x_transposed.data(), y.data(), m.data(), m.rows());
}

}  // namespace kalfem
