#pragma once

#include <optional>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/statistics/band_clusters.hpp"

namespace kalfem {

/// Normalised innovations of a filter that knows the constant unknowns, and their derivatives by these in the filter's
/// state, from one run at the last estimates of `history` and one for each unknown beside it. Unknowns that drift keep
/// their priors. Samples before `first` do not count. Nothing if one of the runs fails or if they would need too much
/// memory.
std::optional<SensitiveInnovations> innovation_sensitivity(const AugmentedModel& augmented_model,
                                                           const FilterInput& input, EstimationOptions options,
                                                           const UnknownsHistory& history, Eigen::Index first);

}  // namespace kalfem
