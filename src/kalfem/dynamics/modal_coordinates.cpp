// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/modal_coordinates.hpp"

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rounding = 1e-13;         ///< of the largest eigenvalue
constexpr double negligible_rate = 1e-10;  ///< of the largest damping: what a reduction leaves of a zero

/// Phi^T (C + C_m) Phi without what rounding leaves between modes that do not act on each other.
MatrixXd modal_damping(const LocallyNonlinearSystem& physical, const MatrixXd& shapes) {
  const MatrixXd product = shapes.transpose() * physical.full_damping() * shapes;
  MatrixXd damping = 0.5 * (product + product.transpose());
  const VectorXd own = damping.diagonal().cwiseAbs();
  const double floor = negligible_rate * (own.size() > 0 ? own.maxCoeff() : 0.0);
  return (damping.cwiseAbs().array() <= floor).select(0.0, damping);
}

}  // namespace

// The dense generalised eigenproblem gives Phi and M Phi. Everything is projected with them; squares of frequencies and
// damping terms at the level of rounding become zero, so that the blocks of the system's matrix stay as small as they
// are.
ModalCoordinates::ModalCoordinates(const LocallyNonlinearSystem& physical) {
  const Index n = physical.size();
  const MatrixXd mass(physical.mass);
  const bool definite = Eigen::LLT<MatrixXd>(mass).info() == Eigen::Success;  // the solver does not say so
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(MatrixXd(physical.stiffness), mass);
  if (!definite || pairs.info() != Eigen::Success)
    throw InvalidInput("the mass matrix of the filter's model is not positive definite",
                       "every degree of freedom needs a mass",
                       "reduce the substructure or give the degree of freedom a mass");
  shapes = pairs.eigenvectors();
  mass_weighted_modes = mass * shapes;
  VectorXd squares = pairs.eigenvalues();
  for (auto& square : squares)
    if (std::abs(square) <= rounding * squares.cwiseAbs().maxCoeff()) square = 0.0;

  for (Index i = 0; i < n; ++i) system.dofs.push_back("mode " + std::to_string(i + 1));
  system.mass = MatrixXd(MatrixXd::Identity(n, n)).sparseView();
  system.stiffness = MatrixXd(squares.asDiagonal()).sparseView();
  system.damping = modal_damping(physical, shapes).sparseView();
  system.connectors = physical.connectors;
  for (auto& connector : system.connectors) connector.deformation = shapes.transpose() * connector.deformation;
  system.inputs = physical.inputs;
  for (auto& input : system.inputs)
    for (auto* load : {&input.value, &input.rate, &input.acceleration}) *load = shapes.transpose() * *load;
}

OutputMap outputs_of_modes(const OutputMap& of_motion, const MatrixXd& shapes) {
  OutputMap of_modes = of_motion;
  for (auto rows : {&OutputMap::displacement, &OutputMap::velocity, &OutputMap::acceleration})
    if (of_motion.size() > 0) of_modes.*rows = MatrixXd(of_motion.*rows * shapes).sparseView();
  return of_modes;
}

namespace {

// See the header for the equations. Steps: check that the damped modes Phi are modes of K and C as well, that is
// A Phi = M Phi diag(Phi^T A Phi) for A = K and C; extend M, C, K by the modes' own diagonal entries; split every load,
// those of inputs and of connectors, into the parts that act on the remainder and on the modes.
/// Relative departure of A Phi from M Phi diag(Phi^T A Phi) that rounding and the eigensolver's tolerance leave.
constexpr double commuting_tolerance = 1e-5;

/// diag(Phi^T A Phi) where A Phi = M Phi diag(...), each mode against the size of A's largest action on the modes.
std::optional<VectorXd> diagonal_action(const SparseMatrix& matrix, const MatrixXd& shapes,
                                        const MatrixXd& mass_weighted_modes) {
  const MatrixXd action = matrix * shapes;
  const VectorXd diagonal = (shapes.cwiseProduct(action)).colwise().sum();
  const MatrixXd rest = action - mass_weighted_modes * diagonal.asDiagonal();
  const double scale = (mass_weighted_modes * diagonal.asDiagonal()).colwise().norm().maxCoeff();
  if (rest.colwise().norm().maxCoeff() > commuting_tolerance * scale) return std::nullopt;
  return diagonal;
}

/// diag(matrix, diagonal).
SparseMatrix extended(const SparseMatrix& matrix, const VectorXd& diagonal) {
  const Index n = matrix.rows(), p = diagonal.size();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(matrix.nonZeros() + p));
  for (Index column = 0; column < n; ++column)
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) entries.emplace_back(it.row(), column, it.value());
  for (Index i = 0; i < p; ++i) entries.emplace_back(n + i, n + i, diagonal[i]);
  SparseMatrix result(n + p, n + p);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// [(1 - M Phi Phi^T) p; Phi^T p].
VectorXd split_load(const DampedModeSplit& split, const VectorXd& load) {
  const VectorXd modal = split.shapes.transpose() * load;
  VectorXd result(load.size() + modal.size());
  result << load, modal;
  if (!modal.isZero()) result.head(load.size()) -= split.mass_weighted_modes * modal;
  return result;
}

}  // namespace

VectorXd DampedModeSplit::split(const VectorXd& motion) const {
  const VectorXd modal = mass_weighted_modes.transpose() * motion;
  VectorXd result(motion.size() + modal.size());
  result << motion - shapes * modal, modal;
  return result;
}

VectorXd DampedModeSplit::merge(const VectorXd& coordinates) const {
  return coordinates.head(shapes.rows()) + shapes * coordinates.tail(shapes.cols());
}

OutputMap DampedModeSplit::outputs(const OutputMap& of_motion) const {
  OutputMap of_coordinates = of_motion;
  if (of_motion.size() == 0) return of_coordinates;
  for (auto rows : {&OutputMap::displacement, &OutputMap::velocity, &OutputMap::acceleration}) {
    const SparseRows& given = of_motion.*rows;
    const SparseRows modal = MatrixXd(given * shapes).sparseView();
    std::vector<Eigen::Triplet<double>> entries;
    for (Index row = 0; row < given.rows(); ++row) {
      for (SparseRows::InnerIterator it(given, row); it; ++it) entries.emplace_back(row, it.col(), it.value());
      for (SparseRows::InnerIterator it(modal, row); it; ++it)
        entries.emplace_back(row, shapes.rows() + it.col(), it.value());
    }
    (of_coordinates.*rows).resize(given.rows(), shapes.rows() + shapes.cols());
    (of_coordinates.*rows).setFromTriplets(entries.begin(), entries.end());
  }
  return of_coordinates;
}

std::optional<DampedModeSplit> split_damped_modes(const LocallyNonlinearSystem& system) {
  const auto& damped = system.modal_damping;
  if (damped.rates.size() == 0) return std::nullopt;
  DampedModeSplit split{{}, damped.modes.shapes, system.mass * damped.modes.shapes};
  const auto stiffness = diagonal_action(system.stiffness, split.shapes, split.mass_weighted_modes);
  const auto damping = diagonal_action(system.damping, split.shapes, split.mass_weighted_modes);
  if (!stiffness || !damping) return std::nullopt;

  auto& in_q = split.system;
  in_q.dofs = system.dofs;
  for (Index i = 0; i < damped.rates.size(); ++i) in_q.dofs.push_back("damped mode " + std::to_string(i + 1));
  in_q.mass = extended(system.mass, VectorXd::Ones(damped.rates.size()));
  in_q.stiffness = extended(system.stiffness, *stiffness);
  in_q.damping = extended(system.damping, *damping + damped.rates);
  in_q.connectors = system.connectors;
  for (auto& connector : in_q.connectors) connector.deformation = split_load(split, connector.deformation);
  in_q.inputs = system.inputs;
  for (auto& input : in_q.inputs)
    for (auto* load : {&input.value, &input.rate, &input.acceleration}) *load = split_load(split, *load);
  return split;
}

}  // namespace kalfem
