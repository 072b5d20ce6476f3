// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/rigid_body.hpp"

#include <algorithm>

#include "kalfem/base/random.hpp"
#include "kalfem/linalg/scaling.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/mesh/connectivity.hpp"

namespace kalfem {
namespace {

std::vector<Eigen::Index> nodes_of_set(const Mesh& mesh, const std::string& name) {
  const auto found = mesh.node_sets.find(name);
  return found == mesh.node_sets.end() ? std::vector<Eigen::Index>{} : found->second;
}

}  // namespace

bool has_only_scalar_points(const FiniteElementModel& model) {
  const auto count = static_cast<Eigen::Index>(nodes_of_set(model.mesh, scalar_points).size());
  return count > 0 && count == model.mesh.node_count();
}

Eigen::MatrixXd rigid_body_modes(const FiniteElementModel& model, const AssembledModel& assembled,
                                 const Eigen::Vector3d& centre) {
  Eigen::MatrixXd modes(assembled.size(), 6);
  for (Eigen::Index i = 0; i < assembled.size(); ++i) {
    const auto& [node, direction] = assembled.dofs[static_cast<std::size_t>(i)];
    modes.row(i) = rigid_row(direction, model.mesh.nodes.col(node) - centre, model.mesh.axes_of(node));
  }
  for (const auto node : nodes_of_set(model.mesh, scalar_points))
    if (const auto place = assembled.find({node, 0}); place >= 0) modes.row(place).setZero();
  return modes;
}

Eigen::Vector3d moving_mass(const FiniteElementModel& model, const AssembledModel& assembled,
                            const SparseMatrix& mass) {
  if (has_only_scalar_points(model)) return Eigen::Vector3d::Constant(mass.sum());
  const Eigen::MatrixXd translations = rigid_body_modes(model, assembled).leftCols<3>();
  return (translations.transpose() * (mass * translations)).diagonal();
}

MassProperties mass_properties(const FiniteElementModel& model, const AssembledModel& assembled,
                               const SparseMatrix& mass) {
  if (!has_only_scalar_points(model)) return mass_properties(assembled);
  MassProperties properties;
  properties.mass = mass.sum();
  return properties;
}

MassProperties mass_properties(const AssembledModel& assembled) {
  Matrix6 matrix = Matrix6::Zero();
  for (const auto& part : assembled.rigid_mass)
    matrix += affine_factor(part.powers, assembled.parameters) * part.matrix;
  MassProperties properties;
  properties.mass = matrix.diagonal().head<3>().maxCoeff();
  if (!(properties.mass > 0.0)) return properties;
  // The coupling block is m [c]^T with the cross-product matrix of the centre.
  const Eigen::Matrix3d coupling = matrix.bottomLeftCorner<3, 3>() / properties.mass;
  properties.centre = 0.5 * Eigen::Vector3d(coupling(2, 1) - coupling(1, 2), coupling(0, 2) - coupling(2, 0),
                                            coupling(1, 0) - coupling(0, 1));
  const auto& c = properties.centre;
  properties.inertia = matrix.bottomRightCorner<3, 3>() -
                       properties.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  return properties;
}

namespace {

constexpr double relative_shift = 1e-12;
constexpr double strainless = 3e-14;  ///< Rayleigh quotient of the scaled stiffness

/// D^-1/2 K D^-1/2; rows without stiffness get a 1 on the diagonal and so stay out of the null space.
SparseMatrix with_unit_diagonal(const SparseMatrix& stiffness, const Eigen::VectorXd& scale,
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

/// Combinations of orthonormal columns with a Rayleigh quotient below `strainless`; `forces` are the matrix times them.
Eigen::MatrixXd without_strain(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& forces) {
  if (basis.cols() == 0) return basis;  // of scalar points, which have no rigid-body motions
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(Eigen::MatrixXd(basis.transpose() * forces));
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
    Eigen::MatrixXd found = without_strain(basis, matrix * basis);
    if (found.cols() < block || block == std::min(largest_block, n)) return found;
  }
}

/// Orthonormal basis of the rigid-body motions, n x 6.
Eigen::MatrixXd independent(const Eigen::MatrixXd& motions) {
  if (motions.isZero(0.0)) return Eigen::MatrixXd(motions.rows(), 0);  // of scalar points
  // Points on one line do not move when they turn about it: such a column has no length of its own.
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(unit_columns(motions));
  qr.setThreshold(1e-9);
  return qr.householderQ() * Eigen::MatrixXd::Identity(motions.rows(), qr.rank());
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

/// The six motions of each part alone, n x 6 parts.
Eigen::MatrixXd by_parts(const FiniteElementModel& model, const AssembledModel& assembled,
                         const Eigen::MatrixXd& of_whole) {
  const auto parts = connected_parts(model);
  std::vector<Eigen::Index> part_of(static_cast<std::size_t>(model.mesh.node_count()), 0);
  for (std::size_t part = 0; part < parts.size(); ++part)
    for (const auto node : parts[part]) part_of[static_cast<std::size_t>(node)] = static_cast<Eigen::Index>(part);
  const auto count = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(parts.size()));
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(assembled.size(), 6 * count);
  for (Eigen::Index i = 0; i < assembled.size(); ++i) {
    const auto node = static_cast<std::size_t>(assembled.dofs[static_cast<std::size_t>(i)].node);
    motions.block<1, 6>(i, 6 * part_of[node]) = of_whole.row(i);
  }
  return motions;
}

/// Coordinates in which K has a unit diagonal. Degrees of freedom without stiffness stay apart.
struct UnitDiagonal {
  explicit UnitDiagonal(const SparseMatrix& stiffness) : diagonal(stiffness.diagonal()) {
    root = (diagonal.array() > 0.0).select(diagonal.cwiseSqrt(), 1.0);
    for (Eigen::Index i = 0; i < diagonal.size(); ++i)
      if (!(diagonal[i] > 0.0)) without.push_back(i);
  }

  /// Orthonormal basis of the rigid-body motions in these coordinates, D^1/2 R.
  [[nodiscard]] Eigen::MatrixXd rigid(const FiniteElementModel& model, const AssembledModel& assembled,
                                      bool each_part) const {
    const Eigen::MatrixXd of_whole = rigid_body_modes(model, assembled);
    Eigen::MatrixXd motions = root.asDiagonal() * (each_part ? by_parts(model, assembled, of_whole) : of_whole);
    for (const auto i : without) motions.row(i).setZero();
    return independent(motions);
  }

  Eigen::VectorXd diagonal;
  Eigen::VectorXd root;               ///< square roots of it, 1 where it is 0
  std::vector<Eigen::Index> without;  ///< degrees of freedom without stiffness
};

}  // namespace

std::vector<std::string> find_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled,
                                         const SparseMatrix& stiffness, bool each_part) {
  if (assembled.size() == 0) return {};
  const UnitDiagonal scale(stiffness);
  std::vector<Eigen::Index> rows = scale.without;
  try {
    const SparseMatrix scaled = with_unit_diagonal(stiffness, scale.root.cwiseInverse(), scale.diagonal);
    const Eigen::MatrixXd rigid = scale.rigid(model, assembled, each_part);
    for (const auto row : leading_rows(beside(null_space(scaled), without_strain(rigid, scaled * rigid))))
      rows.push_back(row);
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

std::vector<std::string> find_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled) {
  return find_mechanisms(model, assembled, evaluate(assembled.stiffness, assembled.parameters));
}

std::optional<StiffnessFactor> factor_held(const FiniteElementModel& model, const AssembledModel& assembled,
                                           const SparseMatrix& stiffness, const SparseMatrix& mass, bool each_part) {
  const UnitDiagonal scale(stiffness);
  if (!scale.without.empty()) return {};
  const auto unscaled = scale.root.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd rigid = scale.rigid(model, assembled, each_part);
  const Eigen::MatrixXd forces = unscaled * (stiffness * (unscaled * rigid).eval());
  return factor_held(stiffness, mass, unscaled * without_strain(rigid, forces));
}

}  // namespace kalfem
