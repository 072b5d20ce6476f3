// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/held_out_sensor.hpp"
#include "kalfem/identification/step_budget.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct RecordEstimate;
struct RecordEstimateOptions;

/// What virtual sensors are worth: each sensor in turn is one.
struct HeldOutStudy {
  std::vector<HeldOutSensor> sensors = {};
  std::vector<std::string> not_tried = {};  ///< the budget does not allow them, or the filter stopped without them
  bool stopped = false;                     ///< the budget did not allow all
  std::optional<AdaptedProcessTrial> adapted = {};

  [[nodiscard]] bool proposes() const { return adapted && adapted->mends; }  ///< process noise that adapts
  [[nodiscard]] const HeldOutSensor* worst() const;  ///< of those whose bands do not hold, by motion_inside; or null
};

/// Holds each sensor out in turn: one pass about the estimates, within their deviations, that does not learn from it.
/// Its one-step predictions have the variance S = P + R of motion and noise. With the right model its errors e over
/// sqrt(S) are white noise but for the part w = P / S, which follows the motion in ways that only P tells; so
/// motion_errors() of n samples exceed
///     chi2_f(1 - a) + n w chi2_1(1 - a),   a = .01 / (2 sensors),
/// in less than one of a hundred runs: the second term allows for one error that all of P stands for. Nothing with
/// fewer than two sensors, for a failed estimate, and where the start is read from displacement sensors. Of a record
/// that starts in motion the second half counts.
///
/// Where a band does not hold, the filter runs with process noise that it adapts, from 1, 3 and 10 % of the motion's
/// accelerations; the likeliest is tried on the same sensors (`trial`: whether it is).
HeldOutStudy study_held_out_sensors(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                    const Record& record, const RecordEstimate& estimate,
                                    const RecordEstimateOptions& options, bool trial, StepBudget& budget);

}  // namespace kalfem
