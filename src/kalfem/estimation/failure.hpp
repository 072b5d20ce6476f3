// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// What the end of a run shows beside its outcome.
struct FailureTrace {
  FilterOutcome outcome = FilterOutcome::usable;
  Eigen::Index sample = 0;                ///< at which the filter could not go on
  Eigen::Index computed = 0;              ///< samples that the result holds
  std::optional<Eigen::Index> connector;  ///< whose force was not finite
};

/// Names what most likely made the filter stop, from the samples before: an unknown that ran off from its prior by more
/// than six deviations, a channel whose innovation was more than six times as large as expected, the connector whose
/// force could not be computed, a channel without noise; otherwise rounding. The remedy fits the settings: it never
/// names what the run already does.
EstimationFailure explain_failure(const FailureTrace& trace, const AugmentedModel& model, const FilterInput& input,
                                  const EstimationOptions& options, const EstimationResult& result);

/// What helps against an outcome whose cause is not known: for a filter that runs sample by sample.
std::string remedy_of(FilterOutcome outcome, FilterKind kind);

}  // namespace kalfem
