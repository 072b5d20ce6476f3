// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/coupling.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Modes of the whole structure are those of M and K + sum_j k_j b_j b_j^T, with k_j the stiffness of connector j at
// rest. Their damping C_m acts on the motion relative to the grounds: a slow motion r_i of a ground carries the
// structure along by s_i = K^-1 (load of the ground), which strains nothing and must not be damped. So r_i' has the
// load C_m s_i.
double checked_stiffness(const Connector& connector) {
  const double stiffness = stiffness_at_rest(*connector.law, connector.parameters);
  if (!std::isfinite(stiffness))
    throw InvalidInput("connector '" + connector.name + "' has no stiffness at rest",
                       "modal damping of the whole structure needs a stiffness of every connector",
                       "give the substructures their own damping");
  return stiffness;
}

VectorXd stiffnesses_at_rest(const LocallyNonlinearSystem& system) {
  VectorXd stiffnesses(system.connector_count());
  for (Index j = 0; j < stiffnesses.size(); ++j)
    stiffnesses[j] = checked_stiffness(system.connectors[static_cast<std::size_t>(j)]);
  return stiffnesses;
}

/// s_i, n x grounds.
MatrixXd carried_shapes(const LocallyNonlinearSystem& system, const SparseMatrix& stiffness,
                        const std::vector<Index>& grounds) {
  const VectorXd stiffnesses = stiffnesses_at_rest(system);
  MatrixXd pulls(system.size(), static_cast<Index>(grounds.size()));
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    auto pull = pulls.col(static_cast<Index>(i));
    pull = system.inputs[static_cast<std::size_t>(grounds[i])].value;
    for (Index j = 0; j < stiffnesses.size(); ++j) {
      const auto& connector = system.connectors[static_cast<std::size_t>(j)];
      pull += stiffnesses[j] * connector.base[grounds[i]] * connector.deformation;
    }
  }
  return semidefinite_solve(stiffness, pulls);
}

}  // namespace

double stiffness_at_rest(const ConnectorLaw& law, const VectorXd& parameters) {
  const auto states = static_cast<Index>(law.states().size());
  const ArrayXd zero = ArrayXd::Zero(1);
  const ArrayXXd values = parameters.transpose(), no_states = ArrayXXd::Zero(1, states);
  ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  ArrayXXd end_states(1, states);
  law.respond({0.0, values, zero, zero, no_states, zero, zero, zero},
              {force, stiffness, damping, inertance, end_states});
  return stiffness[0];
}

SparseMatrix stiffness_at_rest(const LocallyNonlinearSystem& system) {
  const VectorXd stiffnesses = stiffnesses_at_rest(system);
  const SparseMatrix directions = system.connector_directions().sparseView();
  const SparseMatrix forces = directions * stiffnesses.asDiagonal();
  return SparseMatrix(system.stiffness + SparseMatrix(forces * SparseMatrix(directions.transpose())));
}

// Steps: assemble the structure with the connectors' stiffness at rest; let add_modal_damping() find its modes and
// their rates; subtract what the grounds' slow motion would be damped by, as a load of their rates; store both.
void add_global_modal_damping(LocallyNonlinearSystem& system, const GlobalModalDamping& damping,
                              const std::vector<Index>& grounds) {
  LinearModel whole;
  whole.dofs = system.dofs;
  whole.mass = system.mass;
  whole.damping = SparseMatrix(system.size(), system.size());
  whole.stiffness = stiffness_at_rest(system);
  whole.modal_damping = system.modal_damping;
  add_modal_damping(
      whole, damping.ratios,
      damping.up_to ? ModalDampingOptions{.up_to = damping.up_to} : ModalDampingOptions{.count = system.size()});
  if (!grounds.empty()) {
    const MatrixXd carried = carried_shapes(system, whole.stiffness, grounds);
    const MatrixXd cross_damping = whole.damping * carried + damping_force(whole.modal_damping, whole.mass, carried);
    for (std::size_t i = 0; i < grounds.size(); ++i)
      system.inputs[static_cast<std::size_t>(grounds[i])].rate += cross_damping.col(static_cast<Index>(i));
  }
  system.damping = SparseMatrix(system.damping + whole.damping);
  system.modal_damping = whole.modal_damping;
}

}  // namespace kalfem
