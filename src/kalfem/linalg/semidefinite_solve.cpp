#include "kalfem/linalg/semidefinite_solve.hpp"

#include "kalfem/linalg/sparse_factor.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

MatrixXd semidefinite_solve(const Matrix& matrix, const MatrixXd& right_side) {
  constexpr double relative_shift = 1e-12, tolerance = 1e-11;
  constexpr int most_refinements = 50;
  const VectorXd diagonal = matrix.diagonal();
  const double elsewhere = diagonal.maxCoeff() > 0.0 ? diagonal.maxCoeff() : 1.0;
  Matrix shifted = matrix;
  Matrix shift(diagonal.size(), diagonal.size());
  shift.reserve(Eigen::VectorXi::Ones(diagonal.size()));
  for (Index i = 0; i < diagonal.size(); ++i)
    shift.insert(i, i) = diagonal[i] > 0.0 ? relative_shift * diagonal[i] : elsewhere;
  shifted += shift;
  const SparseFactor factor(shifted);
  MatrixXd solution = factor.solve(right_side);
  for (int i = 0; i < most_refinements; ++i) {
    const MatrixXd correction = factor.solve(right_side - matrix * solution);
    solution += correction;
    if (correction.norm() <= tolerance * solution.norm()) break;
  }
  return solution;
}

}  // namespace kalfem
