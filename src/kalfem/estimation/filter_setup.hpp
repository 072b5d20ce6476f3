#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

/// An augmented model, its maps and the filter over them: what a run over a record works with.
struct FilterSetup {
  /// `measurement_noise`: R of all sensors.
  FilterSetup(std::shared_ptr<const AugmentedModel> of, const Eigen::MatrixXd& measurement_noise,
              const EstimationOptions& options);
  FilterSetup(const FilterSetup&) = delete;  // the filter works on the maps here
  FilterSetup& operator=(const FilterSetup&) = delete;

  std::shared_ptr<const AugmentedModel> augmented_model;
  ProcessModel transition;
  MeasurementModel measurement;
  std::optional<MeasurementModel> monitored;
  std::unique_ptr<Filter> filter;
};

/// Where the unknowns of the linear part are, or were when the augmented model was linearised about them.
struct LinearEstimate {
  Eigen::VectorXd values, deviations;  ///< one an unknown [its unit]

  /// Whether the augmented model, linearised there, is to be relinearised here. What the tangent leaves out grows
  /// with the square of the move, as a few move^2 / value, and shall be a few per cent of the deviation; and where that
  /// has shrunk, the neighbours stand too far away.
  [[nodiscard]] bool outdates(const LinearEstimate& there) const;
};

/// The setup of the augmented model about `here`, its filter with the estimate of `before`. `first`: the augmented
/// model with which the run started. Throws InvalidInput where the values make no structure.
std::unique_ptr<FilterSetup> relinearised(const AugmentedModel& first, const LinearEstimate& here,
                                          const FilterSetup& before, const Eigen::MatrixXd& measurement_noise,
                                          const EstimationOptions& options);

}  // namespace kalfem
