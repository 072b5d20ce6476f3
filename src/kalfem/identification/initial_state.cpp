// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/initial_state.hpp"

namespace kalfem {

InitialState initial_state(const InitialMotion& initial, const CoupledModel& model) {
  const auto& system = model.system();
  InitialState start = at_rest(system.size(), system.connector_states());
  for (const auto& [point, given] : initial) {
    const Eigen::Index index = model.dof_index(point);
    if (index < 0)
      throw InvalidInput(given.issue("'" + point + "' is not a degree of freedom" + did_you_mean(point, system.dofs),
                                     "", "name a degree of freedom of a lumped substructure"));
    start.displacement[index] = given.value.displacement;
    start.velocity[index] = given.value.velocity;
  }
  return start;
}

}  // namespace kalfem
