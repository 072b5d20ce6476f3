// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/state_coordinates.hpp"

#include "kalfem/dynamics/modal_coordinates.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// diag(Phi, Phi, 1), n_x x n_x.
MatrixXd extended(const MatrixXd& shapes, Index size) {
  const Index n = shapes.rows();
  MatrixXd result = MatrixXd::Identity(size, size);
  result.topLeftCorner(n, n) = result.block(n, n, n, n) = shapes;
  return result;
}

}  // namespace

AugmentedModelForm::AugmentedModelForm(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                                       const std::vector<MeasurementChain>& chains,
                                       const std::vector<InputTreatment>& inputs, StateCoordinates coordinates_)
    : coordinates(system.size() == 0 ? StateCoordinates::physical : coordinates_),  // a component has no modes
      first_order(system, sensors, chains, inputs),
      largest_block(first_order.size()) {
  if (coordinates == StateCoordinates::modal) choose_modal(system, sensors, chains, inputs);
}

void AugmentedModelForm::choose_modal(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                                      const std::vector<MeasurementChain>& chains,
                                      const std::vector<InputTreatment>& inputs) {
  const ModalCoordinates modes(system);
  const FirstOrderForm of_modes(modes.system, outputs_of_modes(sensors, modes.shapes), chains, inputs);
  const BlockDiagonalForm blocks = block_diagonal_form(of_modes.dynamics());
  first_order = of_modes.in_coordinates(blocks, first_order);
  largest_block = blocks.largest_block();
  basis = extended(modes.shapes, first_order.size()) * blocks.basis;
  inverse = blocks.inverse * extended(modes.mass_weighted_modes, first_order.size()).transpose();
  shapes = modes.shapes;
}

LinearOutput AugmentedModelForm::outputs(const OutputMap& of_motion) const {
  return first_order.raw_outputs(shapes.size() > 0 ? outputs_of_modes(of_motion, shapes) : of_motion);
}

MatrixXd AugmentedModelForm::to_physical(const Eigen::Ref<const MatrixXd>& states) const {
  if (basis.size() == 0) return states;
  if (states.cols() == 1) return basis * states.col(0);  // a product with a vector, at every sample
  return basis * states;
}

MatrixXd AugmentedModelForm::from_physical(const Eigen::Ref<const MatrixXd>& states) const {
  return inverse.size() > 0 ? MatrixXd(inverse * states) : MatrixXd(states);
}

}  // namespace kalfem
