// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

// Dense products and the Cholesky factorisation at the sizes of a filter. Up to some tens of states a general library
// spends its time on packing and dispatch; here tiles of the result stay in registers, and from some 160 states on the
// factors are copied in the order in which the tiles read them. One thread. Arrays are contiguous. Nothing is allocated
// but results that change their size and, at the first call of a size, the calling thread's copies.

/// B = A by the widest registers, as the kernels read it: a narrow store delays a wide load of the same bytes.
void copy(const Eigen::MatrixXd& a, Eigen::MatrixXd& b);
/// out = A B.
void multiply(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& out);
/// out = A L with L lower triangular, its zeros included: half the work.
void multiply_lower(const Eigen::MatrixXd& a, const Eigen::MatrixXd& lower, Eigen::MatrixXd& out);
/// out = A B^T.
void multiply_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& out);
/// out += A B^T.
void add_product_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& out);
/// Lower triangle of out += A B^T, a product known to be symmetric; the upper triangle is left without meaning.
void add_symmetric_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& out);
/// Lower triangle of out -= A A^T; the upper triangle is left without meaning.
void subtract_square(const Eigen::MatrixXd& a, Eigen::MatrixXd& out);

/// Lower triangular L with L L^T = P (lower triangle read), zeros above; false where a pivot is not larger than
/// `pivot_floor` times the variance on its diagonal. `lower` then holds nothing of use.
bool cholesky(const Eigen::MatrixXd& p, double pivot_floor, Eigen::MatrixXd& lower);

/// B <- B L^-T in place, for few columns.
void solve_on_the_right(const Eigen::MatrixXd& lower, Eigen::MatrixXd& b);

}  // namespace kalfem
