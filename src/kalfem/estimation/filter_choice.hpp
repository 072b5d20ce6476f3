// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/filter.hpp"

namespace kalfem {

/// The filter of a run, the augmented model in the coordinates that suit it, and why.
struct FilterChoice {
  FilterKind filter = FilterKind::unscented;
  std::shared_ptr<const AugmentedModel> augmented_model;
  std::string reason;  ///< in words
};

/// Returns the requested filter, or by default the partially linear one, which needs the fewest sigma points. It
/// propagates the covariance in O(n^2) if the linear part splits into blocks of at most a tile; otherwise it works in
/// physical coordinates with a dense covariance. `options.coordinates` is chosen here. Throws InvalidInput as
/// AugmentedModel does.
FilterChoice choose_filter(std::optional<FilterKind> requested, const LocallyNonlinearSystem& system,
                           const OutputMap& sensors, const std::vector<MeasurementChain>& chains,
                           AugmentedModelOptions options);

}  // namespace kalfem
