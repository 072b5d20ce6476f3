#include "kalfem/estimation/filter_choice.hpp"

#include "kalfem/estimation/kernels/tile_layout.hpp"

namespace kalfem {
namespace {

std::string counted(Eigen::Index count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// What the sigma points of a partially linear filter stand for.
std::string arguments_in_words(const AugmentedModel& augmented_model) {
  const auto& system = augmented_model.system();
  return counted(system.connector_count(), "connector") + " and " +
         counted(augmented_model.layout().unknowns, "unknown");
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
  if (block <= tile_size)
    return {FilterKind::partially_linear, modal,
            asked + "linear but for " + arguments_in_words(*modal) +
                ": sigma points of these alone, and the covariance moves in blocks of at most " +
                std::to_string(block)};
  return {FilterKind::partially_linear, make(StateCoordinates::physical),
          asked + "linear but for " + arguments_in_words(*modal) +
              ": sigma points of these alone; the covariance is dense because " + std::to_string(block) +
              " states of the linear part share their poles and cannot be separated"};
}

}  // namespace kalfem
