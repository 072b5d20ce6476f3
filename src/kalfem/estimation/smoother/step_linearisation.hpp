// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/estimation/smoother/adjoint.hpp"

namespace kalfem {

/// The transform of a map's arguments that suits the filter: sigma points, or slopes at the mean where it is extended.
ArgumentTransform argument_transform_of(const EstimationOptions& options);

/// Statistical linearisation of what a filter has just done, as the adjoint passes it. Maps keep the inputs, and the
/// mean about which linear unknowns act, that the filter's step had. One thread.
class StepLinearisation {
public:
  explicit StepLinearisation(const EstimationOptions& options) : moments_(argument_transform_of(options)) {}

  /// Of the prediction from the estimate `before`; its `map` is the caller's. False where the process model cannot be
  /// evaluated.
  [[nodiscard]] bool linearise_prediction(FilterSetup& setup, const Gaussian& before, LinearisedStep& step);
  /// Of the update of the estimate `predicted`, before the next prediction. Without a measured channel it is empty.
  /// False where the measurement model cannot be evaluated.
  [[nodiscard]] bool linearise_update(FilterSetup& setup, const Gaussian& predicted, const Innovation& innovation,
                                      LinearisedMeasurement& measurement);

private:
  bool evaluate(PartiallyLinearMap& map, const Gaussian& about);

  ArgumentMoments moments_;
};

}  // namespace kalfem
