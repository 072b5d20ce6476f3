// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <functional>

#include "kalfem/linalg/long_vectors.hpp"

namespace kalfem {

// Products of long vectors X = [x_0 x_1 ...] with a symmetric sparse matrix A, n x n, both halves of which are stored.
// They work by panels, so that nothing else has the size of the vectors.

/// Calls visit(j, X_p, A X_p) for the panels X_p of the leading `count` vectors, one after the other; j is the place
/// of the first. Where A has no entries there are none.
void visit_products(const Eigen::SparseMatrix<double>& A, const LongVectors& X, Eigen::Index count,
                    const std::function<void(Eigen::Index first, Eigen::Ref<Eigen::MatrixXd> panel,
                                             const LongVectors::Columns& product)>& visit);

/// X^T A X of the leading `count` vectors X, symmetric to the last bit.
Eigen::MatrixXd gram(const LongVectors& X, const Eigen::SparseMatrix<double>& A, Eigen::Index count);

/// sqrt(x^T A x) of each vector x, for a semi-definite A.
Eigen::VectorXd lengths(const LongVectors& X, const Eigen::SparseMatrix<double>& A);

/// (1 - Q Q^T A) X in place of X.
void project_out(const LongVectors& Q, const Eigen::SparseMatrix<double>& A, LongVectors& X);

}  // namespace kalfem
