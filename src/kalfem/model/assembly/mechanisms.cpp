#include "kalfem/model/assembly/mechanisms.hpp"

#include <algorithm>

#include "kalfem/base/random.hpp"
#include "kalfem/linalg/scaling.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/mass_properties.hpp"

namespace kalfem {
namespace {

constexpr double relative_shift = 1e-12;
constexpr double strainless = 3e-14;  ///< Rayleigh quotient of the scaled stiffness

/// D^-1/2 K D^-1/2; rows without stiffness get a 1 on the diagonal and so stay out of the null space.
SparseMatrix scaled_stiffness(const SparseMatrix& stiffness, const Eigen::VectorXd& scale,
                              const Eigen::VectorXd& diagonal) {
  SparseMatrix scaled = scale.asDiagonal() * stiffness * scale.asDiagonal();
  SparseMatrix ones(diagonal.size(), diagonal.size());
  ones.reserve(Eigen::VectorXi::Ones(diagonal.size()));
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (!(diagonal[i] > 0.0)) ones.insert(i, i) = 1.0;
  return scaled + ones;
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ() *
         Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

/// Combinations of orthonormal columns with a Rayleigh quotient below `strainless`.
Eigen::MatrixXd without_strain(const SparseMatrix& matrix, const Eigen::MatrixXd& basis) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(Eigen::MatrixXd(basis.transpose() * (matrix * basis)));
  const auto count = (ritz.eigenvalues().array() < strainless).count();
  return basis * ritz.eigenvectors().leftCols(count);
}

/// Orthonormal basis of the null space, as far as a growing block of columns reaches.
Eigen::MatrixXd null_space(const SparseMatrix& matrix) {
  constexpr Eigen::Index first_block = 16, largest_block = 256;
  constexpr int iterations = 6;
  const Eigen::Index n = matrix.rows();
  SparseMatrix identity(n, n);
  identity.setIdentity();
  const SparseFactor factor(SparseMatrix(matrix + relative_shift * identity));
  RandomStream random(1, "null space");
  for (Eigen::Index block = std::min(first_block, n);; block = std::min({2 * block, largest_block, n})) {
    Eigen::MatrixXd basis = orthonormal(Eigen::MatrixXd::NullaryExpr(n, block, [&] { return random.normal(); }));
    for (int i = 0; i < iterations; ++i) basis = orthonormal(factor.solve(basis));
    Eigen::MatrixXd found = without_strain(matrix, basis);
    if (found.cols() < block || block == std::min(largest_block, n)) return found;
  }
}

/// Orthonormal basis of the rigid-body motions of the free degrees of freedom that strain nothing.
Eigen::MatrixXd free_rigid_motions(const SparseMatrix& matrix, const Eigen::MatrixXd& scaled_modes) {
  // Points on one line do not move when they turn about it: such a column has no length of its own.
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(unit_columns(scaled_modes));
  qr.setThreshold(1e-9);
  const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(scaled_modes.rows(), qr.rank());
  return without_strain(matrix, basis);
}

/// Orthonormal basis of what the null space holds beside the rigid-body motions.
Eigen::MatrixXd beside(const Eigen::MatrixXd& space, const Eigen::MatrixXd& rigid) {
  if (space.cols() == 0) return space;
  const Eigen::JacobiSVD<Eigen::MatrixXd> parts(space - rigid * (rigid.transpose() * space), Eigen::ComputeThinU);
  // Singular values are 1 for what stays and rounding for what was a rigid-body motion.
  return parts.matrixU().leftCols((parts.singularValues().array() > 0.5).count());
}

/// One row for each column: holding these rows still leaves only the zero combination of the columns.
std::vector<Eigen::Index> leading_rows(const Eigen::MatrixXd& columns) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns.transpose());
  const auto& order = qr.colsPermutation().indices();
  return {order.data(), order.data() + columns.cols()};
}

}  // namespace

std::vector<std::string> find_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled) {
  if (assembled.size() == 0) return {};
  const SparseMatrix stiffness = evaluate(assembled.stiffness, assembled.parameters);
  const Eigen::VectorXd diagonal = stiffness.diagonal();
  const Eigen::VectorXd root = (diagonal.array() > 0.0).select(diagonal.cwiseSqrt(), 1.0);
  const SparseMatrix scaled = scaled_stiffness(stiffness, root.cwiseInverse(), diagonal);
  Eigen::MatrixXd rigid = root.asDiagonal() * rigid_body_modes(model, assembled);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (!(diagonal[i] > 0.0)) {
      rows.push_back(i);
      rigid.row(i).setZero();
    }
  try {
    const auto space = null_space(scaled);
    for (const auto row : leading_rows(beside(space, free_rigid_motions(scaled, rigid)))) rows.push_back(row);
  } catch (const NotPositiveDefinite& error) {
    throw InvalidInput("the stiffness matrix is indefinite or almost singular at or before " +
                           dof_name(model.mesh, assembled.dofs[static_cast<std::size_t>(error.column())]),
                       "strain energy must be positive", "check for matrices and springs with negative stiffness");
  }
  std::ranges::sort(rows);
  std::vector<std::string> names;
  for (const auto row : rows) names.push_back(dof_name(model.mesh, assembled.dofs[static_cast<std::size_t>(row)]));
  return names;
}

}  // namespace kalfem
