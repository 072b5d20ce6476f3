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

ModalCoordinates::ModalCoordinates(const LocallyNonlinearSystem& physical) {
  const Index n = physical.size();
  const MatrixXd mass(physical.mass);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(MatrixXd(physical.stiffness), mass);
  if (pairs.info() != Eigen::Success)
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

}  // namespace kalfem
