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

/// What a filter made of a record, and the filter and model that did.
struct FilteredRecord {
  FilterRun run;
  EstimationResult result;
  /// The model at the end: linearised about the last values of the unknowns of the linear part, where there are some.
  [[nodiscard]] std::shared_ptr<const AugmentedModel> augmented_model() const {
    return result.augmented_model ? result.augmented_model : run.choice.augmented_model;
  }
};

/// Runs the filter that suits the problem over the record; the options' kind of filter is chosen here, and `monitored`
/// are outputs of the setup's model. Modal coordinates of close poles are an ill-conditioned basis: where the
/// covariance loses its sign there, the run is made again in physical coordinates, where a step costs more. A failure
/// is in the result. Throws InvalidInput as make_filter_run() and estimate() do.
FilteredRecord run_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                          const FullRecord& record, EstimationOptions options);

/// Root mean square of the samples that are not missing.
double rms_of_present(const Eigen::Ref<const Eigen::VectorXd>& channel);

int processors();
/// Threads that the settings ask for, or one a processor.
int filter_threads(const EstimationSettings& settings);

}  // namespace kalfem
