// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/rerun.hpp"

namespace kalfem {

EstimationOptions rerun_options(const FilterRun& run, const EstimationSettings& settings,
                                const RecordEstimate& estimate) {
  EstimationOptions options{.filter = run.choice.filter,
                            .unscented = settings.unscented,
                            .threads = filter_threads(settings),
                            .state_means = false,
                            .state_deviations = false,
                            .adaptive_noise = settings.adaptive_noise,
                            .held_out = estimate.held_out};
  options.outliers.treatment = estimate.outliers;
  return options;
}

}  // namespace kalfem
