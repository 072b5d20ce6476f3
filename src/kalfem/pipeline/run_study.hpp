// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/diagnosis/diagnose.hpp"
#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/identification/frequency_course.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/pipeline/frequency_response_outcome.hpp"
#include "kalfem/pipeline/inference_outcome.hpp"
#include "kalfem/pipeline/placement_outcome.hpp"
#include "kalfem/pipeline/statics_outcome.hpp"
#include "kalfem/pipeline/validation_outcome.hpp"
#include "kalfem/prediction/base_driven.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/identified_case.hpp"
#include "kalfem/study/structural_modifications.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"
#include "kalfem/updating/sensitivity_check.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// One estimated or predicted quantity of one point, with the reference if there is one.
struct PointQuantity {
  std::string point;
  ObservedQuantity quantity = ObservedQuantity::displacement;
  Eigen::VectorXd mean;
  Eigen::VectorXd deviation;            ///< empty if not known
  Eigen::VectorXd truth;                ///< empty if not known
  std::optional<double> nrmse;          ///< against the truth, after settling
  std::optional<double> nrmse_in_band;  ///< of accelerations and strains: the NRMSE in the excitation's band
  std::optional<double> coverage = {};  ///< of strains: share of the truth in the 95 % band, after settling
};

/// The reference solution and the record made from it.
struct SimulationOutcome {
  ConvergedSolution reference;
  Record measurements;                ///< with noise, one channel a sensor
  std::vector<PointQuantity> points;  ///< the reported points and connectors, free of noise
  double seconds = 0.0;
};

/// Undamped free vibration of one substructure as the case gives it.
struct SubstructureModes {
  std::string name;
  Eigen::Index dofs = 0;
  double mass = 0.0;            ///< with the fixed degrees of freedom [kg]
  Eigen::VectorXd frequencies;  ///< [Hz]; only the lowest of a finite-element model
  Eigen::MatrixXd shapes;       ///< dofs x modes, mass-normalised
};

/// Displacement of every degree of freedom of a finite-element substructure at some times, for pictures.
struct FieldSeries {
  std::string name;  ///< "frame_simulated"
  std::string substructure;
  std::vector<double> times;     ///< [s]
  Eigen::MatrixXd displacement;  ///< dofs of the full model x times
};

/// The estimation with what a run reports of it. After a failure its series end with the last sample that was computed.
struct EstimationOutcome : RecordEstimate {
  /// Displacement, velocity, acceleration of points; deformation, rate, force of connectors; strain of gauges.
  std::vector<PointQuantity> points;
  std::vector<PointQuantity> smoothed_points;  ///< the same from the whole record, where the case asks for it
  /// With unknown inputs: motions and forces whose standard deviation is more than half of their size.
  std::vector<std::string> hardly_known;
  std::optional<FrequencyCourse> frequencies;  ///< over time, where the report asks for them
  std::optional<FrequencyBand> band;           ///< of the excitation, if it has one
  std::optional<Diagnosis> diagnosis;          ///< where the numbers contradict themselves: which mistake explains it
  double seconds = 0.0;
  double first_answer_seconds = 0.0;  ///< of these, until the first answer
};

struct PredictionOutcome {
  std::string substructure;
  std::vector<PointQuantity> points;
  double seconds = 0.0;
};

/// One evaluation of an updating.
struct UpdatingStep {
  bool accepted = false;
  Eigen::VectorXd tried;       ///< parameters
  Eigen::VectorXd parameters;  ///< last accepted ones
  double residual = 0.0;       ///< rms of the weighted residual there
  double seconds = 0.0;
};

/// A point at which searches from several starts ended.
struct FoundMinimum {
  Eigen::VectorXd parameters;
  double residual = 0.0;  ///< rms of the weighted residual
  double cost = 0.0;      ///< half the sum of squares, with the priors' share: the lowest one is the result
  int reached = 0;        ///< by so many starts
  bool converged = false;
};

/// One frequency response, measured and of the model with its best factor.
struct FrfCurve {
  std::string name;                          ///< "2 per force at 1"
  std::string quantity, unit;                ///< "acceleration", "(m/s^2)/N"
  Eigen::VectorXd lines;                     ///< [Hz]
  Eigen::VectorXcd measured, before, after;  ///< H
  bool magnitudes_only = false;              ///< the measured one has no phases
  Eigen::VectorXd coherence;                 ///< of the measurement; empty: not known
  std::optional<double> scale;               ///< best factor on the updated model, if it is free
};

/// A comparison before and after the updating.
struct ComparisonResult {
  std::string name, kind;
  double weight = 1.0;
  Eigen::Index size = 0;
  double rms_initial = 0.0, rms_final = 0.0;           ///< of the residual, in standard deviations
  std::string derivatives;                             ///< of a driven record: which ones, and why
  std::vector<FrfCurve> responses;                     ///< of frequency responses
  std::vector<PairedMode> modes_initial, modes_final;  ///< of natural frequencies
  Eigen::MatrixXd mac_initial, mac_final;              ///< measured x the model's elastic modes
};

struct UpdatingOutcome {
  std::string method;  ///< name of the method, in words
  std::vector<ComparisonResult> comparisons;
  Eigen::VectorXd values;  ///< one per parameter
  ParameterStatistics statistics;
  RobustStatistics robust;
  std::vector<std::string> remarks;  ///< parameters that the data cannot identify, one sentence each
  std::optional<Termination> end;    ///< of the least-squares search; nothing if there was none
  std::string termination;           ///< why it stopped, in words
  bool converged = false;
  double residual_initial = 0.0, residual_final = 0.0;  ///< rms of the weighted residual
  int evaluations = 0, iterations = 0;
  int resumed_at = 0;  ///< evaluations that an earlier run had made
  std::vector<UpdatingStep> trace;
  std::vector<FoundMinimum> minima;                  ///< of several starts, lowest cost first; otherwise empty
  std::vector<SensitivityComparison> sensitivities;  ///< if the case asks for them
  Eigen::VectorXd unknowns_before;  ///< last estimates of the filter before the updating; empty: no filter
  double seconds = 0.0;
};

/// The results of a run; steps that did not run are empty.
struct StudyResults {
  std::vector<SubstructureModes> modes;
  Eigen::VectorXd
      joined_frequencies;  ///< of all parts together, where joints unite some [Hz], see joined_frequencies()
  std::vector<FieldSeries> fields;
  std::optional<SimulationOutcome> simulation;
  std::optional<EstimationOutcome> estimation;
  std::optional<PredictionOutcome> prediction;
  std::optional<UpdatingOutcome> updating;
  std::optional<ValidationOutcome> validation;
  std::vector<StructuralModificationResult> modifications;
  std::optional<InferenceOutcome> inference;
  std::optional<PlacementOutcome> placement;
  std::optional<StaticsOutcome> statics;
  std::optional<FrequencyResponseOutcome> frequency_response;
  std::vector<std::string> warnings;  ///< about the results, in addition to those of the study
  Verdict verdict;
  std::optional<IdentifiedCase> identified;  ///< of a usable run with an estimation or an updating
  std::string failure;                       ///< why a step failed, in words; empty if all ran to their end
  bool interrupted = false;                  ///< it was asked to stop
  PhaseTimes phases;  ///< "modes", "frequency_response", "diagnose", "validate", "verdict"; others have their `seconds`
  double total_seconds = 0.0;

  /// Whether every step ran to its end.
  [[nodiscard]] bool complete() const { return failure.empty(); }
  /// Whether the numbers can be used as well: nothing in them contradicts itself.
  [[nodiscard]] bool usable() const { return complete() && verdict.state() != VerdictState::unusable; }
  /// Why they cannot, in words: the failure, or the worst reason of the verdict. Empty if they can.
  [[nodiscard]] std::string why_unusable() const;
};

/// What a run ends with: the step that a verb of the command names, with all that it needs; or everything.
enum class Step { modes, simulate, estimate, predict, update, infer, place, statics, frequency_response, everything };

struct RunOptions {
  Progress progress = {};             ///< of the whole run: "simulate (1 of 3): reference 3 of at most 7"
  std::filesystem::path folder = {};  ///< where long steps keep their checkpoints; empty: nowhere
  std::function<void(int number, const UpdatingStep&)> on_updating_step = {};
  /// Called with what the run found so far, judged, once its estimation has its first answer.
  std::function<void(const StudyResults&)> on_first_answer = {};
  std::function<SimulationOutcome()> simulation = {};  ///< gives that of this case where it is made already
  bool keep_finished = false;  ///< asked to stop, the run returns the steps that are finished; otherwise it throws
};

/// The simulated or the measured record, with the noise of each channel; the study or the results own it.
const Record& record_of(const Study& study, const StudyResults& results);

/// Runs the steps that the case declares, as far as the last one needs them. An updating runs first, so the estimation
/// and the prediction use the updated structure; inference and placement start from the case's own.
StudyResults run_study(const Study& study, Step last, const RunOptions& options = {});

}  // namespace kalfem
