#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

/// An augmented model, its maps and the filter over them: what a run over a record works with.
struct FilterSetup {
  FilterSetup(std::shared_ptr<const AugmentedModel> of, const EstimationOptions& options);

  std::shared_ptr<const AugmentedModel> augmented_model;
  ProcessModel transition;
  std::unique_ptr<Filter> filter;
  MeasurementModel measurement;
  std::optional<MeasurementModel> monitored;
};

/// Where the unknowns of the linear part are, or were when the augmented model was linearised about them.
struct LinearEstimate {
  Eigen::VectorXd values, deviations;  ///< one an unknown [its unit]

  /// Whether the augmented model is to be linearised anew here after it was there. What the tangent leaves out grows
  /// with the square of the move, as a few move^2 / value, and shall be a few per cent of the deviation; and where that
  /// has shrunk, the neighbours stand too far away.
  [[nodiscard]] bool outdates(const LinearEstimate& there) const;
};

/// The apparatus of the augmented model about `here`, its filter with the estimate that `apparatus` has. `first`: the
/// augmented model as the run began with it. Throws InvalidInput where the values make no structure.
std::unique_ptr<FilterSetup> relinearised(const AugmentedModel& first, const LinearEstimate& here,
                                          const FilterSetup& filter_setup, const EstimationOptions& options);

}  // namespace kalfem
