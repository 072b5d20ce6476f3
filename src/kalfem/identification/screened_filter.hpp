#pragma once

#include "kalfem/identification/refined_filter.hpp"
#include "kalfem/identification/sensor_events.hpp"

namespace kalfem {

/// A run of the filter over what the sensors measured while they worked.
struct ScreenedFilter {
  RefinedFilter refined;
  std::vector<SensorEvent> events;                     ///< what is wrong with the record or missing in it
  OutlierTreatment outliers = OutlierTreatment::keep;  ///< in this run
  std::vector<HeldOutSamples> held_out;                ///< in this run
};

/// run_refined_filter() without the stretches in which a sensor is dead, stuck or saturated, and with outliers treated
/// as the settings say. A record without such events is run once, with the same result as without this search:
/// 1. Stretches of a constant value are held out. Where their prediction agrees with them, they come back.
/// 2. Silent and saturated sensors are found by comparing the channels with their predictions, and held out.
/// 3. With `outliers: auto`, a run in which single samples lie far from predictions that otherwise hold is repeated
/// with
///    robust updates.
/// Each of these is a further run. `OutlierTreatment::keep` searches for nothing but missing samples. Noise that is
/// stated relative to a channel's rms is that of the samples in use.
ScreenedFilter run_screened_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                   const Record& record, EstimationOptions options);

}  // namespace kalfem
