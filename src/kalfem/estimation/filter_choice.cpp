// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/filter_choice.hpp"

#include "kalfem/estimation/kernels/tile_layout.hpp"

namespace kalfem {
namespace {

std::string counted(Eigen::Index count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// What of the model is nonlinear, and how the filter treats it.
std::string nonlinear_part_in_words(const AugmentedModel& augmented_model) {
  const auto connectors = augmented_model.system().connector_count();
  const auto parameters = augmented_model.layout().unknowns;
  if (connectors + parameters == 0) return "the model is linear: it is propagated exactly";
  return "only " + counted(connectors, "connector") + " and " + counted(parameters, "parameter") +
         (connectors + parameters == 1 ? " is" : " are") +
         " nonlinear: sigma points span these; the rest is propagated exactly";
}

}  // namespace

FilterChoice choose_filter(std::optional<FilterKind> requested, const LocallyNonlinearSystem& system,
                           const OutputMap& sensors, const std::vector<MeasurementChain>& chains,
                           AugmentedModelOptions options) {
  const auto make = [&](StateCoordinates coordinates) {
    options.coordinates = coordinates;
    return std::make_shared<const AugmentedModel>(system, sensors, chains, options);
  };
  if (requested && *requested != FilterKind::partially_linear)
    return {*requested, make(StateCoordinates::physical), "requested by the case"};
  const std::string asked = requested ? "requested by the case; " : "";
  const auto modal = make(StateCoordinates::modal);
  const Eigen::Index block = modal->augmented_model_form().largest_block;
  if (block <= tile_size) return {FilterKind::partially_linear, modal, asked + nonlinear_part_in_words(*modal)};
  return {FilterKind::partially_linear, make(StateCoordinates::physical),
          asked + nonlinear_part_in_words(*modal) + "; the covariance is dense because " + std::to_string(block) +
              " states of the linear part have equal poles and cannot be separated"};
}

}  // namespace kalfem
