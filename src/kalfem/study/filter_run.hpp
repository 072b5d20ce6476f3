#pragma once

#include "kalfem/estimation/filter_choice.hpp"
#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Everything that the case's record holds, with the noise of each channel.
struct FullRecord {
  TimeSeries series;
  std::vector<double> noise;  ///< standard deviation per channel
};

/// The record that was read, or that the simulation made.
FullRecord full_record(const Study& study, const StudyResults& results);

/// Samples that must not be missing: the first ones, where the start is read from them, and all of a channel that
/// drives an interface of the augmented model.
void check_needed_samples(const Study& study, IssueList& issues);

/// A filter with its augmented model, and the part of the record that it sees.
struct FilterRun {
  FilterChoice choice;
  TimeSeries measurements;  ///< of the sensors that the augmented model uses
  Eigen::VectorXd noise;    ///< standard deviation per sensor
  Record record;
};

/// `coordinates`: of the augmented model; chosen by what suits the filter where they are not given.
FilterRun make_filter_run(const Study& study, const AugmentedModelSetup& setup, const FullRecord& record,
                          std::optional<StateCoordinates> coordinates = std::nullopt);

/// Throws InvalidInput where the filter of the case's `estimate` could not be made or run, as far as it shows before.
void check_filter(const Study& study);

int processors();
/// Threads that the case asks for, or one a processor.
int filter_threads(const Study& study);

}  // namespace kalfem
