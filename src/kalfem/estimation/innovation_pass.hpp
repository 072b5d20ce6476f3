// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// Sees the innovation of every sample, in order; one without channels where nothing was measured.
using InnovationSink = std::function<void(Eigen::Index sample, const Innovation& innovation)>;

/// A pass of the filter over the record, from the model's prior, that keeps nothing but what `keep` takes: the
/// innovations of estimate() at the cost of its predictions and updates. Of the options, `filter`, `unscented`,
/// `threads`, `outliers` and `held_out` count; the noise is as stated. Returns why it stopped, `usable` at the end of
/// the record.
FilterOutcome pass_innovations(const std::shared_ptr<const AugmentedModel>& augmented_model, const FilterInput& input,
                               const EstimationOptions& options, const InnovationSink& keep);

}  // namespace kalfem
