// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// Estimates of every sample from the whole record.
struct SmoothedRecord {
  EstimatedSeries state;     ///< the augmented state in physical coordinates
  EstimatedSeries unknowns;  ///< in the parameters' own units
  EstimatedSeries monitored;
  Eigen::MatrixXd monitored_excess;  ///< deviations that EstimationOptions::excess adds, quantities x samples
};

struct SmootherOptions {
  /// Memory for the estimates that are kept at once [byte]. Less of it costs further runs of the filter.
  double memory = 256e6;
};

/// Fixed-interval smoother after estimate() with the same arguments and `filtered` as its result, which has no failure.
///
/// The filter runs over the record again, first to set checkpoints, then from each checkpoint, the last first, over the
/// segment that follows it. A segment's linearisations stay in memory until the adjoint recursion has passed it. A
/// sample costs O(n^2) where the filter's does. Nothing where a map cannot be evaluated at a smoothed estimate.
/// docs/theory/smoother.md.
std::optional<SmoothedRecord> smooth(const AugmentedModel& augmented_model, const FilterInput& input,
                                     const EstimationOptions& options, const EstimationResult& filtered,
                                     const SmootherOptions& smoother = {});

}  // namespace kalfem
