#pragma once

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter_choice.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/records/time_series.hpp"

namespace kalfem {

/// Everything that was recorded, with the noise of each channel.
struct FullRecord {
  TimeSeries series;
  std::vector<double> noise;              ///< standard deviation per channel
  std::optional<Eigen::Index> used = {};  ///< samples that the filter learns from, all by default; the rest is for
                                          ///< comparison only
};

/// First samples of the record from which the motion at its start is read.
constexpr Eigen::Index samples_at_start = 4;

/// A filter with its model, and the part of the record that it sees.
struct FilterRun {
  FilterChoice choice;
  TimeSeries measurements;  ///< of the sensors that the filter uses
  Eigen::VectorXd noise;    ///< standard deviation per sensor
  Record record;
};

/// `coordinates`: of the filter's model; chosen by what suits the filter where they are not given.
FilterRun make_filter_run(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                          const FullRecord& record, std::optional<StateCoordinates> coordinates = std::nullopt);

/// Root mean square of the samples that are not missing.
double rms_of_present(const Eigen::Ref<const Eigen::VectorXd>& channel);

int processors();
/// Threads that the settings ask for, or one a processor.
int filter_threads(const EstimationSettings& settings);

}  // namespace kalfem
