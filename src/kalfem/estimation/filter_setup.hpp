// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

/// An augmented model, its maps and the filter over them, for one run over a record.
struct FilterSetup {
  /// `measurement_noise`: R of all sensors.
  FilterSetup(std::shared_ptr<const AugmentedModel> of, const Eigen::MatrixXd& measurement_noise,
              const EstimationOptions& options);
  FilterSetup(const FilterSetup&) = delete;  // the filter works on the maps here
  FilterSetup& operator=(const FilterSetup&) = delete;

  /// The connector whose force the last evaluation of a map could not compute; nothing where all could.
  [[nodiscard]] std::optional<Eigen::Index> failed_connector() const;

  std::shared_ptr<const AugmentedModel> augmented_model;
  ProcessModel transition;
  MeasurementModel measurement;
  std::optional<MeasurementModel> monitored;
  std::unique_ptr<Filter> filter;
};

/// The inputs of the interval from sample k - 1 to sample k, which are given at so many instants of it or at its ends.
void set_inputs_to(Eigen::Index k, const FilterInput& input, Eigen::Index instants, ProcessModel& transition);
/// Carries the filter's estimate over the interval from sample k - 1 to sample k of the record.
FilterOutcome predict_to(Eigen::Index k, const FilterInput& input, FilterSetup& setup);
/// Conditions it on what was measured at sample k, but for what is held out there; `y` is a work array.
FilterOutcome update_at(Eigen::Index k, const FilterInput& input, const std::vector<HeldOutSamples>& held_out,
                        FilterSetup& setup, Eigen::VectorXd& y, Innovation& innovation);

/// Values of the unknowns of the linear part, now or at the last linearisation of the augmented model.
struct LinearEstimate {
  Eigen::VectorXd values, deviations;  ///< one per unknown [its unit]

  /// Whether the augmented model, linearised there, needs relinearisation here. The error of the tangent grows with the
  /// square of the move, about move^2 / value, and must stay a few per cent of the deviation. A much smaller deviation
  /// is a second reason: the neighbours are then too far away.
  [[nodiscard]] bool outdates(const LinearEstimate& there) const;
};

/// These after sample k, or by their prior. `places`: linear_unknowns() of the model; `estimated`: all unknowns.
LinearEstimate linear_estimate(const AugmentedModel& augmented_model, const std::vector<Eigen::Index>& places,
                               const EstimatedSeries& estimated, std::optional<Eigen::Index> k = std::nullopt);

/// The setup of a model, its filter with the estimate of `before`.
std::unique_ptr<FilterSetup> moved_to(const std::shared_ptr<const AugmentedModel>& model, const FilterSetup& before,
                                      const Eigen::MatrixXd& measurement_noise, const EstimationOptions& options);

/// Adds to the variance of one state of the filter's estimate.
void widen(FilterSetup& setup, Eigen::Index state, double variance);

/// That of the augmented model about `here`. `first`: the augmented model with which the run started. Throws
/// InvalidInput if the values are not admissible.
std::unique_ptr<FilterSetup> relinearised(const AugmentedModel& first, const LinearEstimate& here,
                                          const FilterSetup& before, const Eigen::MatrixXd& measurement_noise,
                                          const EstimationOptions& options);

}  // namespace kalfem
