#include "kalfem/reduction/ritz.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Part of a column's size that the others must leave for it to count.
constexpr double least_remainder = 1e-5;

}  // namespace

MatrixXd orthonormal(const MatrixXd& columns, const Eigen::SparseMatrix<double>& mass) {
  if (columns.cols() == 0) return columns;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(columns.transpose() * (mass * columns));
  const Index independent = (gram.eigenvalues().array() > least_remainder * least_remainder).count();
  const VectorXd sizes = gram.eigenvalues().tail(independent).cwiseSqrt();
  return columns * (gram.eigenvectors().rightCols(independent) * sizes.cwiseInverse().asDiagonal());
}

LowestModes uncoupled(const MatrixXd& columns, const Eigen::SparseMatrix<double>& stiffness,
                      const Eigen::SparseMatrix<double>& mass) {
  if (columns.cols() == 0) return {VectorXd(), columns, {}, 0};
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(MatrixXd(columns.transpose() * (stiffness * columns)),
                                                                 MatrixXd(columns.transpose() * (mass * columns)));
  return {pairs.eigenvalues(), columns * pairs.eigenvectors(), {}, columns.cols()};
}

}  // namespace kalfem
