#include "kalfem/linalg/dense_modes.hpp"

#include <limits>
#include <vector>

#include "kalfem/linalg/sparse_select.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// R with R R^T = M, n x rank.
MatrixXd root(const MatrixXd& mass) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(mass);
  const double largest = solver.eigenvalues().tail(1)[0];
  const Index rank = (solver.eigenvalues().array() > 1e-13 * largest).count();
  return solver.eigenvectors().rightCols(rank) * solver.eigenvalues().tail(rank).cwiseSqrt().asDiagonal();
}

DensePairs condensed_modes(const Eigen::SparseMatrix<double>& mass, const SparseFactor& shifted, double shift) {
  std::vector<Index> massive;
  const VectorXd diagonal = mass.diagonal();
  for (Index j = 0; j < diagonal.size(); ++j)
    if (diagonal[j] > 0.0) massive.push_back(j);
  const MatrixXd loads = root(MatrixXd(select(mass, massive, massive)));
  MatrixXd displacements = MatrixXd::Zero(mass.rows(), loads.cols());
  displacements(massive, Eigen::all) = loads;
  shifted.solve(displacements, displacements);
  const MatrixXd flexibility = loads.transpose() * displacements(massive, Eigen::all);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (flexibility + flexibility.transpose()));
  const VectorXd shifted_values = solver.eigenvalues().reverse().cwiseInverse();
  return {shifted_values.array() - shift,
          displacements * (solver.eigenvectors().rowwise().reverse() * shifted_values.asDiagonal())};
}

}  // namespace

DensePairs dense_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                       const SparseFactor& shifted, double shift) {
  if ((mass.diagonal().array() > 0.0).all()) {
    const MatrixXd dense_mass(mass);
    const Eigen::LLT<MatrixXd> factor(dense_mass);
    if (factor.info() == Eigen::Success && factor.rcond() > 1e-13) {
      const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(stiffness), dense_mass);
      return {solver.eigenvalues(), solver.eigenvectors()};
    }
  }
  return condensed_modes(mass, shifted, shift);
}

}  // namespace kalfem
