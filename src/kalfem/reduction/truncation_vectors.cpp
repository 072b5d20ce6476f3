#include "kalfem/reduction/truncation_vectors.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Part of a column's size that the kept modes must leave for it to count.
constexpr double least_remainder = 1e-5;

void remove_kept(MatrixXd& shapes, const MatrixXd& kept, const SparseMatrix& mass) {
  for (int pass = 0; pass < 2; ++pass) shapes -= kept * (kept.transpose() * (mass * shapes));
}

/// Columns of unit size that are not nearly combinations of the others, M-orthonormal.
MatrixXd orthonormal(const MatrixXd& shapes, const SparseMatrix& mass) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(shapes.transpose() * (mass * shapes));
  const Index independent = (gram.eigenvalues().array() > least_remainder * least_remainder).count();
  const VectorXd sizes = gram.eigenvalues().tail(independent).cwiseSqrt();
  return shapes * (gram.eigenvectors().rightCols(independent) * sizes.cwiseInverse().asDiagonal());
}

}  // namespace

LowestModes truncation_vectors(const Partition& parts, const SparseMatrix& mass_ib, const MatrixXd& static_modes,
                               const MatrixXd& kept, const SparseFactor& stiffness) {
  MatrixXd shapes = stiffness.solve(MatrixXd(parts.mass_ii * static_modes + MatrixXd(mass_ib)));
  for (Index j = 0; j < shapes.cols(); ++j)
    if (const double size = std::sqrt(shapes.col(j).dot(parts.mass_ii * shapes.col(j))); size > 0.0)
      shapes.col(j) /= size;
  remove_kept(shapes, kept, parts.mass_ii);
  shapes = orthonormal(shapes, parts.mass_ii);
  if (shapes.cols() == 0) return {VectorXd(), shapes, {}, 0};
  remove_kept(shapes, kept, parts.mass_ii);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> uncoupled(
      MatrixXd(shapes.transpose() * (parts.stiffness_ii * shapes)),
      MatrixXd(shapes.transpose() * (parts.mass_ii * shapes)));
  return {uncoupled.eigenvalues(), shapes * uncoupled.eigenvectors(), {}, shapes.cols()};
}

}  // namespace kalfem
