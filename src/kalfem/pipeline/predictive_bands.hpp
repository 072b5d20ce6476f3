#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Response at some draws of the posterior beside the record: the simulation under the known excitation through every
/// sensor, 95 % of it with the sensor's noise. Empty where the excitation is not known, the filter has a local model,
/// or no simulation ran to its end.
std::vector<PredictiveBand> predictive_bands(const Study& study, const Record& record, const SampleSet& samples,
                                             int threads);

}  // namespace kalfem
