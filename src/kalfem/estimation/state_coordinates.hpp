// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/dynamics/first_order_form.hpp"

namespace kalfem {

/// What the linear part of an augmented model's state is made of.
enum class StateCoordinates {
  physical,  ///< displacements and velocities, states of inputs and sensors
  modal      ///< amplitudes xi, x = T xi, in which the propagator is block diagonal (BlockDiagonalForm)
};

/// The first-order form of an augmented model and the way between its coordinates and the physical ones.
struct AugmentedModelForm {
  /// Throws InvalidInput where FirstOrderForm does, and in modal coordinates where the mass matrix is not positive
  /// definite.
  AugmentedModelForm(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                     const std::vector<MeasurementChain>& chains, const std::vector<InputTreatment>& inputs,
                     StateCoordinates coordinates);

  StateCoordinates coordinates;
  FirstOrderForm first_order;      ///< in these coordinates
  Eigen::Index largest_block = 0;  ///< of the propagator; in physical coordinates its size
  Eigen::MatrixXd basis, inverse;  ///< T and T^-1, n_x x n_x; empty in physical coordinates
  Eigen::MatrixXd shapes;          ///< Phi of the undamped modes; empty in physical coordinates

  /// Outputs of the system as functions of the state, without measurement chains.
  [[nodiscard]] LinearOutput outputs(const OutputMap& of_motion) const;

  // Rows of states, n_x x any, there and back.
  [[nodiscard]] Eigen::MatrixXd to_physical(const Eigen::Ref<const Eigen::MatrixXd>& states) const;
  [[nodiscard]] Eigen::MatrixXd from_physical(const Eigen::Ref<const Eigen::MatrixXd>& states) const;

private:
  void choose_modal(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                    const std::vector<MeasurementChain>& chains, const std::vector<InputTreatment>& inputs);
};

}  // namespace kalfem
