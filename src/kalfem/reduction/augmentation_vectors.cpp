#include "kalfem/reduction/augmentation_vectors.hpp"

#include "kalfem/reduction/ritz.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void remove_kept(MatrixXd& shapes, const MatrixXd& kept, const SparseMatrix& mass) {
  for (int pass = 0; pass < 2; ++pass) shapes -= kept * (kept.transpose() * (mass * shapes));
}

}  // namespace

LowestModes augmentation_vectors(const Partition& parts, const SparseMatrix& mass_ib, const MatrixXd& constraint_modes,
                                 const MatrixXd& kept, const SparseFactor& stiffness) {
  MatrixXd shapes = stiffness.solve(MatrixXd(parts.mass_ii * constraint_modes + MatrixXd(mass_ib)));
  for (Index j = 0; j < shapes.cols(); ++j)
    if (const double size = std::sqrt(shapes.col(j).dot(parts.mass_ii * shapes.col(j))); size > 0.0)
      shapes.col(j) /= size;
  remove_kept(shapes, kept, parts.mass_ii);
  shapes = orthonormal(shapes, parts.mass_ii);
  if (shapes.cols() == 0) return {VectorXd(), shapes, {}, 0};
  remove_kept(shapes, kept, parts.mass_ii);
  return uncoupled(shapes, parts.stiffness_ii, parts.mass_ii);
}

}  // namespace kalfem
