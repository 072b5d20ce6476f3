// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter_choice.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/record_start.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// First samples of the record from which the motion at its start is read.
constexpr Eigen::Index samples_at_start = 4;

/// A filter with its model, and what it runs over.
struct FilterRun {
  FilterChoice choice;
  FilterInput input;
  RecordStart start;
};

/// The rows of the record that are the sensors of the filter's model, in its order, with their noise; a channel of the
/// record is found by the sensor's name. `coordinates`: of the filter's model; chosen by what suits the filter where
/// they are not given.
///
/// A structure starts at rest where the record's time is zero and its first samples allow it, or where the setup says
/// that this was decided before. Otherwise its initial state is unknown (set_moving_start()), unless the settings state
/// it.
FilterRun make_filter_run(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                          std::optional<StateCoordinates> coordinates = std::nullopt);

/// The run of another model of the same structure over the same record, or over one with other corrections of its
/// sensors. Substeps, kind of filter, excitation, what is assumed of the start (StatePrior) and, unless given, the
/// coordinates are those of `first`, so that the models are all that differs. It costs no more than the model. Throws
/// InvalidInput as make_filter_run() does.
FilterRun make_filter_run_like(const FilterRun& first, const EstimationProblemPtr& problem,
                               const AugmentedModelSetup& setup, const Record& record,
                               std::optional<StateCoordinates> coordinates = std::nullopt);

/// The model of such a run alone.
std::shared_ptr<const AugmentedModel> augmented_model_like(const FilterRun& first, const EstimationProblemPtr& problem,
                                                           const AugmentedModelSetup& setup, const Record& record,
                                                           std::optional<StateCoordinates> coordinates = std::nullopt);

/// One of several filters that were tried over a record.
struct FilterAttempt {
  FilterKind filter = FilterKind::unscented;
  StateCoordinates coordinates = StateCoordinates::physical;
  std::optional<EstimationFailure> failure;  ///< nothing: it ran to the end
};

/// Result of a filter over a record, with that filter and its model.
struct FilteredRecord {
  FilterRun run;
  EstimationResult result;
  std::vector<FilterAttempt> attempts = {};  ///< in the order in which they were made, the result's the last
  /// The model at the end, linearised about the final values of the unknowns of its linear part.
  [[nodiscard]] std::shared_ptr<const AugmentedModel> augmented_model() const {
    return result.augmented_model ? result.augmented_model : run.choice.augmented_model;
  }
};

/// What to try after a filter that stopped with this outcome: forms of the same filter that lose fewer digits, the
/// cheapest first. A covariance that lost its sign in modal coordinates, the partially linear filter in physical ones,
/// where a step costs more; then, unless the kind of filter was asked for, with its covariance as a triangular factor.
/// Nothing where no such form helps.
std::vector<FilterAttempt> attempts_after(const FilterAttempt& failed, bool kind_is_given);

/// Runs the filter that suits the problem over the record; the options' kind of filter is chosen here, and `monitored`
/// are outputs of the setup's model. Where it stops, tries attempts_after() it; if none runs to the end, the result is
/// that of the first. Where the kind was asked for and stops, the remedy says whether filter: auto runs to the end,
/// which was tried. A failure is in the result. Throws InvalidInput as make_filter_run() and estimate() do.
FilteredRecord run_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                          EstimationOptions options);

/// Filter steps of one run over the record, see StepBudget.
double steps_of_run(const EstimationProblem& problem, const Record& record, int substeps);

/// Threads of the settings, or one per processor.
int filter_threads(const EstimationSettings& settings);

}  // namespace kalfem
