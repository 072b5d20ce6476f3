// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

enum class UpdatingMethod { least_squares, evolution };

/// The parameters of an updating.
struct UpdatingSetup {
  std::vector<UpdatingParameter> parameters;
  std::vector<StructureBinding> bindings;              ///< positions of theta in the substructures
  std::vector<std::optional<double>> true_parameters;  ///< one per parameter
};

/// The refined parameters by their names.
inline PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values) {
  PresentValues present;
  for (const auto& [index, target] : updating.bindings) present[target.name] = values[index];
  return present;
}

}  // namespace kalfem
