// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/sensor_events.hpp"

namespace kalfem {

/// Runs of the filter over what the sensors measured while they worked: without the stretches in which a sensor is
/// dead, stuck or saturated, and with outliers treated as the settings say. A record without such events is run once,
/// with the same result as without this search:
/// 1. Stretches of a constant value are held out. Where their prediction agrees with them, they come back.
/// 2. Silent and saturated sensors are found by comparing the channels with their predictions, and held out.
/// 3. With `outliers: auto`, a run in which single samples lie far from predictions that otherwise hold is repeated
///    with robust updates; so is one that contradicts itself where the record holds spikes, if that is far better.
/// Each of these is a further run. `OutlierTreatment::keep` searches for nothing but missing samples. Noise that is
/// stated relative to a channel's rms is that of the samples in use.
class Screening {
public:
  Screening(EstimationProblemPtr problem, AugmentedModelSetup setup, Record record, EstimationOptions options);

  /// Runs the filter again until it finds no more events. Later calls, with other substeps, go on from what was found.
  FilteredRecord run(int substeps);

  /// The start of the record is that of this run from now on.
  void keep_start(const RecordStart& start) { setup_.starts_at_rest = !start.moving; }

  /// Every run from now on passes several times over the record, each time from the estimates of the one before:
  /// parameters and, where the structure moves at the first sample, the motion there.
  void pass_again(int passes, bool moving) {
    options_.passes = passes;
    setup_.options.keep_initial_state = setup_.options.keep_initial_state || moving;
  }

  /// What is wrong with the record or missing in it, by the result of the last run.
  [[nodiscard]] std::vector<SensorEvent> events(const EstimationResult& result) const;
  /// As they are for the last run: with its outliers, its samples that are held out, and the noise that holds for them.
  [[nodiscard]] const EstimationOptions& options() const { return options_; }
  [[nodiscard]] const Record& record() const { return record_; }
  [[nodiscard]] const AugmentedModelSetup& setup() const { return setup_; }
  [[nodiscard]] double steps() const { return steps_; }  ///< filter steps of all runs

private:
  FilteredRecord run_once(int substeps);
  void count_spikes_little(FilteredRecord& filtered, int substeps);
  bool changes(const FilteredRecord& filtered);
  [[nodiscard]] bool is_confirmed(const HeldOutSamples& stretch) const;
  bool hold_out(const std::vector<HeldOutSamples>& found);
  [[nodiscard]] std::vector<SensorEvent> faults(const EstimationResult& result) const;
  void state_noise(const EstimationResult& result);

  EstimationProblemPtr problem_;
  AugmentedModelSetup setup_;
  Record record_, measured_;  ///< as given, with the noise that holds now; the sensors' channels of it
  EstimationOptions options_;
  std::vector<HeldOutSamples> confirmed_;
  double steps_ = 0.0;
  bool spikes_tried_ = false;  ///< a robust run because of the record's spikes
};

}  // namespace kalfem
